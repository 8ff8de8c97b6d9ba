#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Measured relative pose of two poses: odometry, a loop closure.
//
//   r = W Log( Z^-1 T_i^-1 T_j ),  Log of SE(3)            docs/factors/relative_pose.md, Eq. 1
//
// Blocks:  0: T_i  pose (7, PoseManifold)
//          1: T_j  pose (7, PoseManifold)
// r = W [rho | theta], translation [m] before rotation [rad].
// Domain:  everywhere; r jumps where the rotation of Z^-1 T_i^-1 T_j is pi.
class RelativePose final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  using Variables = VariableList<Pose, Pose>;
  enum Block { kPoseI = 0, kPoseJ = 1 };

  // Z: measured T_ij, the pose of j in i. sqrt_information: W, 6 x 6, W^T W = Sigma^-1.
  // Throws InvalidArgument if an argument is not finite.
  RelativePose(const Pose& Z, const Eigen::Matrix<double, 6, 6>& sqrt_information);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const Pose& Z() const { return Z_; }
  const Eigen::Matrix<double, 6, 6>& sqrt_information() const { return W_; }

 private:
  const Pose Z_, Z_inverse_;
  const Eigen::Matrix<double, 6, 6> W_;
};

}  // namespace highwall
