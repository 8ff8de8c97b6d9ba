#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Camera pose measurement from one image, summarized as a Gaussian, where the time offset between
// the clocks of camera and IMU is unknown: the state is that of the body at t_cam + t_d_state, the
// image was taken at t_cam + t_d, and the body moved in between.
//
//   d = t_d - t_d_state,   p = p_WB + d v_WB,   q = q_WB Exp(d omega_B)
//   r = W [ p + R(q) p_BC - p_0 | Log(q_0^-1 q q_BC) ]         docs/factors/camera_pose.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold)   1: v_WB  velocity (3) [m/s]   2: t_d  (1) [s]
// Domain:  everywhere; the Jacobian is discontinuous where the rotation error is pi.
// Source:  loosely coupled fusion with the offset of Qin, Shen 2018 (see the page).
class CameraPose final : public ceres::SizedCostFunction<6, 7, 3, 1> {
 public:
  using Variables = VariableList<Pose, Eigen::Vector3d, double>;
  enum Block { kPose, kVelocity, kTimeOffset };

  // T_WC_0: camera pose estimated from the image. sqrt_information: W, 6 x 6, of any rank; W^T W is
  // the information in the tangent [m, rad] of PoseManifold at T_WC_0. omega_B [rad/s]:
  // bias-corrected rate at the time of the state. t_d_state [s]. Throws InvalidArgument if an
  // argument is not finite.
  CameraPose(const Pose& T_WC_0, const Eigen::Matrix<double, 6, 6>& sqrt_information,
             const Pose& T_BC, const Eigen::Vector3d& omega_B, double t_d_state = 0.0);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Pose T_WC_0_;
  const Eigen::Matrix<double, 6, 6> W_;
  const Pose T_BC_;
  const Eigen::Matrix3d R_CB_;
  const Eigen::Vector3d omega_B_;
  const double t_d_state_;
};

// Same as CameraPose, with the camera extrinsics T_BC and the scale of the depth as variables.
//
//   d = t_d - t_d_state,   p = p_WB + d v_WB,   q = q_WB Exp(d omega_B)
//   r = W [ (p + R(q) p_BC) / s - p_0 | Log(q_0^-1 q q_BC) ]
//                                           docs/factors/extrinsic_camera_pose.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold)   1: v_WB  velocity (3) [m/s]   2: t_d  (1) [s]
//          3: T_BC  pose (7, PoseManifold)   4: s  (1), true depth = s * measured depth
// Domain:  s != 0; the Jacobian is discontinuous where the rotation error is pi.
class ExtrinsicCameraPose final : public ceres::SizedCostFunction<6, 7, 3, 1, 7, 1> {
 public:
  using Variables = VariableList<Pose, Eigen::Vector3d, double, Pose, double>;
  enum Block { kPose, kVelocity, kTimeOffset, kExtrinsics, kScale };

  // Arguments as CameraPose; T_WC_0 is expressed in the scale of the measured depth.
  ExtrinsicCameraPose(const Pose& T_WC_0, const Eigen::Matrix<double, 6, 6>& sqrt_information,
                      const Eigen::Vector3d& omega_B, double t_d_state = 0.0);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Pose T_WC_0_;
  const Eigen::Matrix<double, 6, 6> W_;
  const Eigen::Vector3d omega_B_;
  const double t_d_state_;
};

}  // namespace highwall
