#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/abi.h>
#include <highwall/core/silent_domain.h>

namespace [[gnu::visibility("default")]] highwall {

// A pose of a body among the blocks of a factor, which moves by v_WB [m/s] and omega_B [rad/s] over
// dt = t_d - t_d_state [s].
struct MovingPose {
  std::size_t block = 0;
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero(), omega_B = Eigen::Vector3d::Zero();
  double t_d_state = 0.0;
};

// Wraps any factor on the pose of a body from an image, with the time offset t_d between the clocks
// of the camera and the IMU, t_imu = t_cam + t_d, as an additional variable. The state belongs to
// the time t_cam + t_d_state of the IMU clock; if the image was actually taken at t_cam + t_d, the
// body has moved by then according to its velocity:
//
//   r = r_seen( p_WB + v_WB dt, q_WB Exp(omega_B dt), ... ),  dt = t_d - t_d_state
//                                                  docs/factors/time_offset_factor.md, Eq. 1
//
// A factor on readings of the IMU has several such poses. Where their states belong to the images,
// and the readings to t_cam + t_d_state, their velocities are the negative ones.
//
// Blocks:  those of the wrapped factor, of which poses (7, PoseManifold) move
//          last: t_d  time offset (1) [s]
// Domain: that of the wrapped factor at the moved poses.
// Source: Li, Mourikis, "Online temporal calibration for camera-IMU systems", IJRR 2014, section 3.
class TimeOffsetFactor final : public ceres::CostFunction, public SilentOutsideDomain {
 public:
  // seen: the wrapped factor; its block 0 is T_WB. v_WB [m/s], omega_B [rad/s]: of the body at the
  // time of the state. t_d_state: [s] the offset with which the stamp of the state was computed.
  // Throws InvalidArgument without a factor whose first block is a pose, or if an argument is not
  // finite.
  TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen, const Eigen::Vector3d& v_WB,
                   const Eigen::Vector3d& omega_B, double t_d_state);
  // poses: each of another block. Throws InvalidArgument without a factor or poses, if a block is
  // not a pose or is given twice, or if an argument is not finite.
  TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen, std::vector<MovingPose> poses);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::shared_ptr<const ceres::CostFunction> seen_;
  const std::vector<MovingPose> poses_;
};

}  // namespace highwall
