#include <highwall/factors/scaled_motion.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

ScaledMotion::ScaledMotion(const Pose& Z, const Eigen::Matrix<double, 6, 6>& sqrt_information,
                           const Pose& T_BC)
    : Z_(Z), W_(sqrt_information), T_BC_(T_BC), R_CB_(T_BC.R().transpose()) {
  HIGHWALL_REQUIRE(Z.IsFinite() && T_BC.IsFinite(), "ScaledMotion: Z and T_BC must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "ScaledMotion: sqrt_information must be finite");
}

bool ScaledMotion::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Eigen::Map<const Eigen::Vector3d> p_i(parameters[kPoseI]), p_j(parameters[kPoseJ]);
  const Eigen::Map<const Eigen::Quaterniond> q_i(parameters[kPoseI] + 3);
  const Eigen::Map<const Eigen::Quaterniond> q_j(parameters[kPoseJ] + 3);
  const double inverse_s = 1.0 / parameters[kScale][0];

  const Eigen::Quaterniond q_ij = q_i.conjugate() * q_j;
  const Eigen::Vector3d p_BiCj = q_i.conjugate() * (p_j - p_i) + q_ij * T_BC_.p();
  const Eigen::Quaterniond q_CiCj = T_BC_.q().conjugate() * q_ij * T_BC_.q();
  const Eigen::Vector3d theta = so3::Log(Z_.q().conjugate() * q_CiCj);
  const Eigen::Vector3d p_CiCj = R_CB_ * (p_BiCj - T_BC_.p());
  Vector6 e;
  e << inverse_s * p_CiCj - Z_.p(), theta;
  if (!e.allFinite()) return false;
  Eigen::Map<Vector6> r(residuals);
  r.noalias() = W_ * e;  // Eq. 1
  if (jacobians == nullptr) return true;

  const Eigen::Matrix3d dp = inverse_s * R_CB_;
  const Eigen::Matrix3d R_iW = q_i.conjugate().toRotationMatrix();
  const Eigen::Matrix3d dtheta = so3::RightJacobianInverse(theta) * R_CB_;
  if (jacobians[kPoseI] != nullptr) {  // Eq. 2
    Matrix6 J = Matrix6::Zero();
    J.topLeftCorner<3, 3>() = -dp * R_iW;
    J.topRightCorner<3, 3>() = dp * so3::Hat(p_BiCj);
    J.bottomRightCorner<3, 3>() = -dtheta * q_ij.conjugate().toRotationMatrix();
    PoseManifold::Lift<6>(parameters[kPoseI], W_ * J, jacobians[kPoseI]);
  }
  if (jacobians[kPoseJ] != nullptr) {  // Eq. 3
    Matrix6 J = Matrix6::Zero();
    J.topLeftCorner<3, 3>() = dp * R_iW;
    J.topRightCorner<3, 3>() = -dp * q_ij.toRotationMatrix() * so3::Hat(T_BC_.p());
    J.bottomRightCorner<3, 3>() = dtheta;
    PoseManifold::Lift<6>(parameters[kPoseJ], W_ * J, jacobians[kPoseJ]);
  }
  if (jacobians[kScale] != nullptr) {  // Eq. 4
    Eigen::Map<Vector6> J(jacobians[kScale]);
    J.noalias() = -inverse_s * inverse_s * (W_.leftCols<3>() * p_CiCj);
  }
  return true;
}

}  // namespace highwall
