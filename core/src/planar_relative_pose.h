#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/variable.h>

namespace highwall::internal {

// A measured transform between two poses of the plane.
//
//   r = W [ R_z^T (R_i^T (p_j - p_i) - p_z) | wrap(theta_j - theta_i - theta_z) ]
//                                                                docs/pose_graph.md, Eq. 2
//
// Blocks:  0: [x y theta] of i     1: [x y theta] of j      Euclidean; angles may exceed pi
// Domain:  everywhere; r jumps where the wrapped angle is pi.
class PlanarRelativePose final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  using Variables = VariableList<Eigen::Vector3d, Eigen::Vector3d>;

  // Z: measured [x y theta] of j in i; sqrt_information: W, W^T W = Omega.
  PlanarRelativePose(const Eigen::Vector3d& Z, const Eigen::Matrix3d& sqrt_information);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Eigen::Vector3d Z_;
  const Eigen::Matrix3d W_Rz_;  // W diag(R_z^T, 1)
};

}  // namespace highwall::internal
