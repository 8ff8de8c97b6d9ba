#pragma once

#include <memory>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/abi.h>
#include <highwall/core/silent_domain.h>

namespace [[gnu::visibility("default")]] highwall {

// Wraps any factor on the pose of a body from an image, with the time offset t_d between the clocks
// of the camera and the IMU, t_imu = t_cam + t_d, as an additional variable. The state belongs to
// the time t_cam + t_d_state of the IMU clock; if the image was actually taken at t_cam + t_d, the
// body has moved by then according to its velocity:
//
//   r = r_seen( p_WB + v_WB dt, q_WB Exp(omega_B dt), ... ),  dt = t_d - t_d_state
//                                                  docs/factors/time_offset_factor.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold)
//          1..: blocks of the wrapped factor after its pose
//          last: t_d  time offset (1) [s]
// Domain: that of the wrapped factor at the moved pose.
// Source: Li, Mourikis, "Online temporal calibration for camera-IMU systems", IJRR 2014, section 3.
class TimeOffsetFactor final : public ceres::CostFunction, public SilentOutsideDomain {
 public:
  // seen: the wrapped factor; its block 0 is T_WB. v_WB [m/s], omega_B [rad/s]: of the body at the
  // time of the state. t_d_state: [s] the offset with which the stamp of the state was computed.
  // Throws InvalidArgument without a factor whose first block is a pose, or if an argument is not
  // finite.
  TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen, const Eigen::Vector3d& v_WB,
                   const Eigen::Vector3d& omega_B, double t_d_state);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::shared_ptr<const ceres::CostFunction> seen_;
  const Eigen::Vector3d v_WB_, omega_B_;
  const double t_d_state_;
};

}  // namespace highwall
