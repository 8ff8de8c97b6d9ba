#include "run/velocity_file.h"

#include <string>

#include <fmt/core.h>
#include <Eigen/Core>

#include <highwall/core/atomic_file.h>
#include <highwall/core/stamp.h>

#include "run/covariance_log.h"

namespace highwall::apps {
namespace {

std::string VectorText(const Eigen::Vector3d& v) {
  return fmt::format(" {:.6f} {:.6f} {:.6f}", v.x(), v.y(), v.z());
}

}  // namespace

void WriteVelocities(const std::filesystem::path& path, std::span<const FrameVelocity> velocities) {
  AtomicFile file(path);
  file.stream()
      << "# stamp [s] of a frame, velocity of the camera in the world [m/s], angular rate\n"
         "# along the axes of the camera [rad/s], then the upper triangle of the\n"
         "# covariance of both, row by row\n";
  for (const FrameVelocity& velocity : velocities) {
    file.stream() << FormatStamp(velocity.stamp) << VectorText(velocity.v_WC)
                  << VectorText(velocity.omega_C) << UpperTriangle(velocity.covariance) << '\n';
  }
  file.Commit();
}

}  // namespace highwall::apps
