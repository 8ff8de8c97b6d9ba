#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Power spectral densities of the white noise on the accelerations of a body, per axis.
struct AccelerationNoise {
  double linear = 1.0;   // [m^2 / s^3] > 0
  double angular = 1.0;  // [rad^2 / s^3] > 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Motion prior between two states of a body: constant velocity, disturbed by white noise on its
// linear acceleration in W and on its angular acceleration in B.
//
//   r = W [ p_j - p_i - dt v_i | Log(R_i^T R_j) - dt w_i | v_j - v_i | w_j - w_i ]
//                                                       docs/factors/white_acceleration.md, Eq. 1
//
// Blocks:  0: T_WB_i  pose (7, PoseManifold)   1: u_i = [v_WB | w_B]  velocities (6) [m/s, rad/s]
//          2: T_WB_j                           3: u_j
// Domain:  everywhere; r jumps where the rotation between the poses is pi. Evaluate returns false
//          where a value is not finite.
// Source:  Anderson, Barfoot, "Full STEAM ahead", IROS 2015 (see the page).
class WhiteAcceleration final : public ceres::SizedCostFunction<12, 7, 6, 7, 6> {
 public:
  using Velocities = Eigen::Matrix<double, 6, 1>;
  using Variables = VariableList<Pose, Velocities, Pose, Velocities>;
  enum Block { kPoseI, kVelocitiesI, kPoseJ, kVelocitiesJ };

  // dt: [s] > 0, from i to j. Throws InvalidArgument if an argument is out of range.
  WhiteAcceleration(double dt, const AccelerationNoise& noise);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  const double dt_;
  Vector6 step_, coupling_, rate_;  // diagonals of the blocks of W, Eq. 3
};

}  // namespace highwall
