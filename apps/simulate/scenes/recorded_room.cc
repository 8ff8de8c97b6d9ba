#include "simulate/scenes/recorded_room.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>

#include "simulate/scenes/room.h"

namespace highwall::simulate {
namespace {

constexpr double kLeadIn = 0.6;                    // [s] before the first frame
const Eigen::Vector3d kFree(2.3, 1.8, 2.8);        // [m] half, half and full size of the free space
constexpr double kClearance = 0.3, kLowest = 0.5;  // [m]

// Returns the signed body axis that points up most of the time.
Eigen::Vector3d UpAxis(const RecordedMotion& motion) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImuState& state : motion.states) {
    sum += state.T_WB.q().conjugate() * Eigen::Vector3d::UnitZ();
  }
  Eigen::Index axis = 0;
  sum.cwiseAbs().maxCoeff(&axis);
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  up[axis] = sum[axis] < 0.0 ? -1.0 : 1.0;
  return up;
}

// Enlarges everything by `factor`, including prints.
void Enlarge(double factor, Scene* scene) {
  for (Eigen::Vector3d& vertex : scene->mesh.vertices) vertex *= factor;
  for (Surface& surface : scene->surfaces) {
    surface.origin *= factor;
    surface.magnification *= static_cast<float>(factor);
  }
  for (Light& light : scene->lights) {
    light.p_W *= factor;
    light.power *= factor * factor;
  }
}

}  // namespace

Eigen::Quaterniond LevelCamera(const RecordedMotion& motion) {
  const Eigen::Vector3d up = UpAxis(motion);
  const Eigen::Vector3d forward(std::abs(up.z()), std::abs(up.x()), std::abs(up.y()));
  Eigen::Matrix3d R_BC;
  R_BC << forward.cross(up), -up, forward;
  return Eigen::Quaterniond(R_BC);
}

Simulation SimulateRecordedRoom(const RecordedMotion& motion, SimulationOptions options) {
  const auto lead = static_cast<std::size_t>(std::ceil(kLeadIn / motion.interval));
  HIGHWALL_REQUIRE(motion.states.size() > 3 * lead, "the recorded motion is too short");
  const double duration = motion.interval * static_cast<double>(motion.states.size() - 2 * lead);
  options.duration = std::min(options.duration, duration);
  options.rest = 0.0;
  options.imu.T_BC = Pose(LevelCamera(motion), options.imu.T_BC.p());

  Eigen::AlignedBox3d box;
  for (const ImuState& state : motion.states) box.extend(state.T_WB.p());
  const double lift = std::max(0.0, kLowest - box.min().z());
  const Eigen::Vector3d middle(box.center().x(), box.center().y(), -lift);
  const Eigen::Vector3d needed(0.5 * box.sizes().x() + kClearance,
                               0.5 * box.sizes().y() + kClearance,
                               box.max().z() + lift + kClearance);
  Scene room = MakeRoom(options.seed);
  Enlarge(std::max(1.0, needed.cwiseQuotient(kFree).maxCoeff()), &room);

  RecordedMotion moved = motion;
  for (ImuState& state : moved.states) {
    state.T_WB = Pose(state.T_WB.q(), state.T_WB.p() - middle);
  }
  // Frame 0 corresponds to state `lead`.
  const Stamp shift = Simulation::FirstStamp() - motion.begin -
                      FromSeconds(static_cast<double>(lead) * motion.interval);
  GivenReadings readings{.samples = motion.readings,
                         .first_bias = motion.begin + shift,
                         .bias_interval = motion.interval,
                         .biases = motion.biases};
  for (ImuSample& sample : readings.samples) sample.stamp += shift;
  std::erase_if(readings.samples, [](const ImuSample& sample) { return sample.stamp <= 0; });
  return Simulation(std::move(room), moved.PathOf(options.imu.T_BC, lead), options, {}, {}, {},
                    std::move(readings));
}

}  // namespace highwall::simulate
