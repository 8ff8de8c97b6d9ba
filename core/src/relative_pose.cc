#include <highwall/core/relative_pose.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/internal/se3.h>

namespace highwall {
namespace {

using ConstVector3 = Eigen::Map<const Eigen::Vector3d>;
using ConstQuaternion = Eigen::Map<const Eigen::Quaterniond>;

}  // namespace

RelativePose::RelativePose(const Pose& Z, const Eigen::Matrix<double, 6, 6>& sqrt_information)
    : Z_(Z), Z_inverse_(Z.Inverse()), W_(sqrt_information) {
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "RelativePose: sqrt_information must be finite");
}

bool RelativePose::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const ConstVector3 p_i(parameters[kPoseI]), p_j(parameters[kPoseJ]);
  const ConstQuaternion q_i(parameters[kPoseI] + 3), q_j(parameters[kPoseJ] + 3);
  // Not by class Pose: its constructor throws on non-finite values, and Evaluate must not.
  const Eigen::Quaterniond q_ij = q_i.conjugate() * q_j;
  const Eigen::Vector3d p_ij = q_i.conjugate() * (p_j - p_i);
  const Eigen::Vector3d theta = so3::Log(Z_inverse_.q() * q_ij);
  const Eigen::Vector3d p_E = Z_inverse_.q() * p_ij + Z_inverse_.p();

  se3::Tangent e;
  e << so3::RightJacobianInverse(-theta) * p_E, theta;
  if (!e.allFinite()) return false;
  Eigen::Map<se3::Tangent> r(residuals);
  r = W_ * e;  // Eq. 1
  if (jacobians == nullptr) return true;

  const se3::Matrix6 dr_dE = W_ * se3::RightJacobianInverse(e);  // Eq. 2
  if (jacobians[kPoseI] != nullptr) {
    const Eigen::Matrix3d R_i = q_i.toRotationMatrix();
    const Eigen::Matrix3d R_ji = q_ij.conjugate().toRotationMatrix();
    se3::Matrix6 dE_dpose;  // Eq. 3: -Ad(T_ij^-1) diag(R_i^T, I)
    dE_dpose << -R_ji * R_i.transpose(), R_ji * so3::Hat(p_ij), Eigen::Matrix3d::Zero(), -R_ji;
    PoseManifold::Lift<6>(parameters[kPoseI], dr_dE * dE_dpose, jacobians[kPoseI]);
  }
  if (jacobians[kPoseJ] != nullptr) {
    se3::Matrix6 dr_dpose = dr_dE;  // Eq. 4: diag(R_j^T, I)
    dr_dpose.leftCols<3>() = dr_dE.leftCols<3>() * q_j.toRotationMatrix().transpose();
    PoseManifold::Lift<6>(parameters[kPoseJ], dr_dpose, jacobians[kPoseJ]);
  }
  return true;
}

}  // namespace highwall
