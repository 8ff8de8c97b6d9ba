#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Relative motion of a camera between two images in an unknown unit of length, such as the metres
// of a depth camera whose readings are a few percent too long or too short.
//
//   r = W [ R_Ci^T (p_Cj - p_Ci) / s - p_Z | Log(R_Z^T R_Ci^T R_Cj) ],   T_WC = T_WB T_BC
//                                                       docs/factors/scaled_motion.md, Eq. 1
//
// Blocks:  0: T_WB_i  pose (7, PoseManifold)   1: T_WB_j   2: s  (1) true length = s x measured
// Domain:  s != 0; the Jacobian is discontinuous where the rotation error is pi. Evaluate
//          returns false where a value is not finite.
// Source:  the scale of visual-inertial alignment, Mur-Artal, Tardos 2017 (see the page).
class ScaledMotion final : public ceres::SizedCostFunction<6, 7, 7, 1> {
 public:
  using Variables = VariableList<Pose, Pose, double>;
  enum Block { kPoseI, kPoseJ, kScale };

  // Z: measured T_Ci_Cj. sqrt_information: W, 6 x 6, of any rank; W^T W is the information in
  // [measured m, rad]. Throws InvalidArgument if an argument is not finite.
  ScaledMotion(const Pose& Z, const Eigen::Matrix<double, 6, 6>& sqrt_information,
               const Pose& T_BC = Pose());

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Pose Z_;
  const Eigen::Matrix<double, 6, 6> W_;
  const Pose T_BC_;
  const Eigen::Matrix3d R_CB_;
};

}  // namespace highwall
