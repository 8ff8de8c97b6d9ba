#include <highwall/factors/camera_pose.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

CameraPose::CameraPose(const Pose& T_WC_0, const Eigen::Matrix<double, 6, 6>& sqrt_information,
                       const Pose& T_BC, const Eigen::Vector3d& omega_B, double t_d_state)
    : T_WC_0_(T_WC_0),
      W_(sqrt_information),
      T_BC_(T_BC),
      R_CB_(T_BC.R().transpose()),
      omega_B_(omega_B),
      t_d_state_(t_d_state) {
  HIGHWALL_REQUIRE(T_WC_0.IsFinite() && T_BC.IsFinite(),
                   "CameraPose: T_WC and T_BC must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "CameraPose: sqrt_information must be finite");
  HIGHWALL_REQUIRE(omega_B.allFinite() && std::isfinite(t_d_state),
                   "CameraPose: omega_B and t_d_state must be finite");
}

bool CameraPose::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_WB(parameters[kPose]), v_WB(parameters[kVelocity]);
  const Eigen::Map<const Eigen::Quaterniond> q_WB(parameters[kPose] + 3);
  const double d = parameters[kTimeOffset][0] - t_d_state_;

  const Eigen::Quaterniond turn = so3::Exp(d * omega_B_);
  const Eigen::Quaterniond q = q_WB * turn;
  const Eigen::Matrix3d R = q.toRotationMatrix();
  const Eigen::Vector3d theta = so3::Log(T_WC_0_.q().conjugate() * q * T_BC_.q());
  Eigen::Matrix<double, 6, 1> e;
  e << p_WB + d * v_WB + R * T_BC_.p() - T_WC_0_.p(), theta;
  Eigen::Map<Eigen::Matrix<double, 6, 1>> r(residuals);
  r.noalias() = W_ * e;  // Eq. 1
  if (!e.allFinite()) return false;
  if (jacobians == nullptr) return true;

  // Jacobians of e in the body rotation at the time of the image, on the right of q.
  const Eigen::Matrix3d dp_dphi = -R * so3::Hat(T_BC_.p());
  const Eigen::Matrix3d dtheta_dphi = so3::RightJacobianInverse(theta) * R_CB_;
  if (jacobians[kPose] != nullptr) {  // Eq. 2
    const Eigen::Matrix3d dphi_dtheta = turn.conjugate().toRotationMatrix();
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
    J.topLeftCorner<3, 3>().setIdentity();
    J.topRightCorner<3, 3>() = dp_dphi * dphi_dtheta;
    J.bottomRightCorner<3, 3>() = dtheta_dphi * dphi_dtheta;
    PoseManifold::Lift<6>(parameters[kPose], W_ * J, jacobians[kPose]);
  }
  if (jacobians[kVelocity] != nullptr) {  // Eq. 3
    Eigen::Map<Eigen::Matrix<double, 6, 3, Eigen::RowMajor>> J(jacobians[kVelocity]);
    J = d * W_.leftCols<3>();
  }
  if (jacobians[kTimeOffset] != nullptr) {  // Eq. 4; Jr(d omega) omega = omega at a constant rate
    Eigen::Matrix<double, 6, 1> de;
    de << v_WB + dp_dphi * omega_B_, dtheta_dphi * omega_B_;
    Eigen::Map<Eigen::Matrix<double, 6, 1>> J(jacobians[kTimeOffset]);
    J.noalias() = W_ * de;
  }
  return true;
}

}  // namespace highwall
