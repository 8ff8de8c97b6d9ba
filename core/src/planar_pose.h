#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>

// A pose of the plane as the block [x y theta], and as a Pose with z = 0.
namespace highwall::internal {

// In [-pi, pi].
inline double WrapAngle(double angle) {
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

inline Eigen::Vector3d ToPlanar(const Pose& pose) {
  const Eigen::Quaterniond q = pose.q();
  return {pose.p().x(), pose.p().y(), WrapAngle(2.0 * std::atan2(q.z(), q.w()))};
}

inline Pose FromPlanar(const Eigen::Vector3d& planar) {
  const double half = 0.5 * planar.z();
  return Pose(Eigen::Quaterniond(std::cos(half), 0.0, 0.0, std::sin(half)),
              Eigen::Vector3d(planar.x(), planar.y(), 0.0));
}

}  // namespace highwall::internal
