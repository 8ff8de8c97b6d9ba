#include <highwall/factors/camera_pose.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

ExtrinsicCameraPose::ExtrinsicCameraPose(const Pose& T_WC_0,
                                         const Eigen::Matrix<double, 6, 6>& sqrt_information,
                                         const Eigen::Vector3d& omega_B, double t_d_state)
    : T_WC_0_(T_WC_0), W_(sqrt_information), omega_B_(omega_B), t_d_state_(t_d_state) {
  HIGHWALL_REQUIRE(T_WC_0.IsFinite(), "ExtrinsicCameraPose: T_WC must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(),
                   "ExtrinsicCameraPose: sqrt_information must be finite");
  HIGHWALL_REQUIRE(omega_B.allFinite() && std::isfinite(t_d_state),
                   "ExtrinsicCameraPose: omega_B and t_d_state must be finite");
}

bool ExtrinsicCameraPose::Evaluate(double const* const* parameters, double* residuals,
                                   double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_WB(parameters[kPose]), v_WB(parameters[kVelocity]);
  const Eigen::Map<const Eigen::Quaterniond> q_WB(parameters[kPose] + 3);
  const Eigen::Map<const Eigen::Vector3d> p_BC(parameters[kExtrinsics]);
  const Eigen::Map<const Eigen::Quaterniond> q_BC(parameters[kExtrinsics] + 3);
  const double d = parameters[kTimeOffset][0] - t_d_state_;
  const double k = 1.0 / parameters[kScale][0];

  const Eigen::Quaterniond turn = so3::Exp(d * omega_B_);
  const Eigen::Quaterniond q = q_WB * turn;
  const Eigen::Matrix3d R = q.toRotationMatrix();
  const Eigen::Vector3d theta = so3::Log(T_WC_0_.q().conjugate() * q * q_BC);
  Eigen::Matrix<double, 6, 1> e;
  const Eigen::Vector3d p_WC = p_WB + d * v_WB + R * p_BC;
  e << k * p_WC - T_WC_0_.p(), theta;
  Eigen::Map<Eigen::Matrix<double, 6, 1>> r(residuals);
  r.noalias() = W_ * e;  // Eq. 1
  if (!e.allFinite()) return false;
  if (jacobians == nullptr) return true;

  // Jacobians of e in the body rotation at the time of the image, on the right of q.
  const Eigen::Matrix3d Jr_inverse = so3::RightJacobianInverse(theta);
  const Eigen::Matrix3d dp_dphi = -k * R * so3::Hat(p_BC);
  const Eigen::Matrix3d dtheta_dphi = Jr_inverse * q_BC.toRotationMatrix().transpose();
  if (jacobians[kPose] != nullptr) {  // Eq. 2
    const Eigen::Matrix3d dphi_dtheta = turn.conjugate().toRotationMatrix();
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
    J.topLeftCorner<3, 3>() = k * Eigen::Matrix3d::Identity();
    J.topRightCorner<3, 3>() = dp_dphi * dphi_dtheta;
    J.bottomRightCorner<3, 3>() = dtheta_dphi * dphi_dtheta;
    PoseManifold::Lift<6>(parameters[kPose], W_ * J, jacobians[kPose]);
  }
  if (jacobians[kVelocity] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 6, 3, Eigen::RowMajor>> J(jacobians[kVelocity]);
    J = k * d * W_.leftCols<3>();
  }
  if (jacobians[kTimeOffset] != nullptr) {
    Eigen::Matrix<double, 6, 1> de;
    de << k * v_WB + dp_dphi * omega_B_, dtheta_dphi * omega_B_;
    Eigen::Map<Eigen::Matrix<double, 6, 1>> J(jacobians[kTimeOffset]);
    J.noalias() = W_ * de;
  }
  if (jacobians[kExtrinsics] != nullptr) {  // Eq. 3
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
    J.topLeftCorner<3, 3>() = k * R;
    J.bottomRightCorner<3, 3>() = Jr_inverse;
    PoseManifold::Lift<6>(parameters[kExtrinsics], W_ * J, jacobians[kExtrinsics]);
  }
  if (jacobians[kScale] != nullptr) {  // Eq. 4
    Eigen::Map<Eigen::Matrix<double, 6, 1>> J(jacobians[kScale]);
    J.noalias() = -k * k * W_.leftCols<3>() * p_WC;
  }
  return true;
}

}  // namespace highwall
