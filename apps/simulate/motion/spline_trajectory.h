#pragma once

#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>

namespace highwall::simulate {

// Camera pose with its analytic derivatives.
struct CameraMotion {
  Pose T_WC;
  Eigen::Vector3d v_WC = Eigen::Vector3d::Zero();     // velocity of C's origin in W [m/s]
  Eigen::Vector3d a_WC = Eigen::Vector3d::Zero();     // its acceleration in W [m/s^2]
  Eigen::Vector3d w_C = Eigen::Vector3d::Zero();      // angular velocity of C in C [rad/s]
  Eigen::Vector3d alpha_C = Eigen::Vector3d::Zero();  // its derivative in C [rad/s^2]
};

// Closed trajectory, twice continuously differentiable: a uniform cubic B-spline of positions and a
// cumulative one of rotations. Source: Lovegrove, Patron-Perez, Sibley, "Spline Fusion", BMVC 2013,
// equations 3 to 5; derivatives of rotations: Sommer, Usenko, Schubert, Demmel, Cremers, "Efficient
// derivative computation for cumulative B-splines on Lie groups", CVPR 2020, section 4.
class SplineTrajectory {
 public:
  // control: T_WC, one every period / control.size() seconds, at least 4; the curve passes near,
  // not through them. Rotations of neighbours (the first follows the last) differ by less than pi.
  // period [s] > 0. Throws InvalidArgument.
  SplineTrajectory(std::vector<Pose> control, double period);

  double period() const { return period_; }
  // t [s]: any; the curve repeats every period.
  Pose T_WC(double t) const;
  // Returns the same with its time derivatives.
  CameraMotion MotionAt(double t) const;

 private:
  // The four control poses that define the curve at t begin with `first`; u of [0, 1) is the
  // position between the second and the third.
  struct Place {
    std::size_t first = 0;
    double u = 0.0;
  };
  Place PlaceOf(double t) const;
  const Pose& Control(std::size_t i) const { return control_[i % control_.size()]; }

  std::vector<Pose> control_;
  double period_;
};

}  // namespace highwall::simulate
