#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>

namespace [[gnu::visibility("default")]] highwall {

// Twist (screw motion) of the camera in its own frame C, per second: a static point p_C moves by
// -(v + omega x p_C) there.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d omega = Eigen::Vector3d::Zero();  // [rad/s]

  // Returns the twist that leads from pose A to pose B within dt [s], not 0.
  static Twist Between(const Pose& T_AB, double dt);
  // Returns the motion within dt [s], backwards in time if negative: T_(now, now + dt).
  Pose Over(double dt) const;
  // Returns Over(dt) * p, for single points in less time than the pose takes.
  Eigen::Vector3d Transform(double dt, const Eigen::Vector3d& p) const;
  // Velocity of a static point, seen from the camera [m/s].
  Eigen::Vector3d Flow(const Eigen::Vector3d& p_C) const { return -(v + omega.cross(p_C)); }
};

}  // namespace highwall
