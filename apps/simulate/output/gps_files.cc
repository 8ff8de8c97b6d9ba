#include "simulate/output/gps_files.h"

#include <iomanip>
#include <numbers>

#include <highwall/core/stamp.h>
#include <highwall/internal/number_text.h>

#include "simulate/random.h"

namespace highwall::simulate {
namespace {

constexpr std::uint64_t kAlignment = 7101, kNoise = 7102;  // streams of the seed

}  // namespace

Eigen::Vector3d GpsAntenna() {
  return {0.1, -0.5, -0.2};
}

Pose GpsAlignment(const Simulation& simulation) {
  RandomSequence random(Mix(simulation.options().seed + kAlignment));
  const double heading = random.Uniform(-std::numbers::pi, std::numbers::pi);
  const double x = random.Uniform(-500.0, 500.0), y = random.Uniform(-500.0, 500.0),
               z = random.Uniform(0.0, 300.0);
  return Pose::FromTangent({x, y, z}, {0.0, 0.0, heading});
}

std::string GpsCsv(const Simulation& simulation, const GpsOptions& options) {
  const CounterRandom random(Mix(simulation.options().seed + kNoise));
  const Pose T_GW = GpsAlignment(simulation);
  const Eigen::Vector3d sigma = options.sigma * Eigen::Vector3d(1.0, 1.0, 2.0);
  const Stamp first = simulation.StampOf(0), last = simulation.StampOf(simulation.size() - 1);
  TextWriter out;
  out << "# stamp [s],x [m],y [m],z [m],sigma_x [m],sigma_y [m],sigma_z [m]\n"
      << std::fixed << std::setprecision(4);
  for (std::uint64_t i = 0;; ++i) {
    const Stamp stamp = first + FromSeconds(static_cast<double>(i) / options.rate);
    if (stamp > last) return out.str();
    const Eigen::Vector2f plane = random.Normals(2 * i), up = random.Normals(2 * i + 1);
    const Eigen::Vector3d noise =
        sigma.cwiseProduct(Eigen::Vector3f(plane.x(), plane.y(), up.x()).cast<double>());
    const Eigen::Vector3d p_G = T_GW * (simulation.T_WC(stamp) * GpsAntenna()) + noise;
    out << FormatStamp(stamp) << ',' << p_G.x() << ',' << p_G.y() << ',' << p_G.z() << ','
        << sigma.x() << ',' << sigma.y() << ',' << sigma.z() << '\n';
  }
}

std::string GpsCalibrationYaml(const SimulationOptions& options) {
  const Pose T_BC = options.imu.enabled ? options.imu.T_BC : Pose();
  const Eigen::Vector3d l = T_BC * GpsAntenna();
  TextWriter out;
  out << std::setprecision(12) << "gps:\n  antenna: [" << l.x() << ", " << l.y() << ", " << l.z()
      << "]\n";
  return out.str();
}

std::string GpsAlignmentText(const Simulation& simulation) {
  const Pose T_GW = GpsAlignment(simulation);
  TextWriter out;
  out << "# pose of the world of groundtruth.txt in the frame of gps.csv\n"
         "# tx ty tz qx qy qz qw\n"
      << std::fixed << std::setprecision(9);
  for (int i = 0; i < Pose::kSize; ++i) out << (i > 0 ? " " : "") << T_GW.data()[i];
  out << '\n';
  return out.str();
}

}  // namespace highwall::simulate
