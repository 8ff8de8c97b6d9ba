#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>

#include <highwall/frontend/features/twist.h>

namespace highwall {

// Rows of position, rotation, velocity, biases and, behind the 15 of the state, gravity's direction
// in a joint covariance of an inertial state.
namespace state_rows {
inline constexpr int kP = 0, kTheta = 3, kV = 6, kB = 9, kN = 15;
}

// The same after the motion that an IMU measured, its noise added (Forster et al. 2017); that is
// larger where the IMU's residual weighs less than 1 (weight > 0).
InertialEstimate Propagate(const InertialEstimate& from, const ImuPreintegration& imu,
                           const Eigen::Vector3d& gravity_W, double weight = 1.0);

// Pose of the camera and its 6 x 6 covariance in the tangent of PoseManifold.
struct CameraPoseEstimate {
  Pose T_WC;
  Eigen::Matrix<double, 6, 6> covariance;
};
CameraPoseEstimate CameraOf(const InertialEstimate& body, const Pose& T_BC);

// 15 x 15: how an error of the state at the beginning of an interval shows at its end.
Eigen::Matrix<double, 15, 15> Transition(const InertialEstimate& from,
                                         const ImuPreintegration& imu);

// Where a window starts: the first state and the calibration, with their joint uncertainty. At rest
// gravity's direction and the bias of the accelerometer are known together far better than either:
// what couples them must not be lost.
struct InertialPrior {
  InertialEstimate estimate;
  UnitDirection gravity_W;
  double time_offset = 0.0;  // [s] t_d
  std::optional<Pose> T_BC;  // where it is an unknown
  // 3 x 3 of [n t_d], n in the tangent of UnitDirectionManifold at gravity_W [rad, s]; 9 x 9 of
  // [n t_d T_BC], the latter in that of PoseManifold, where it is an unknown.
  Eigen::MatrixXd calibration_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  // 15 x 3 or 15 x 9, of the state with these.
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling = Eigen::Matrix<double, 15, 3>::Zero();

  // 18 x 18 or 24 x 24, all of it.
  Eigen::MatrixXd Joint() const;
  Eigen::MatrixXd JointWithoutTimeOffset() const;
  void SetJoint(const Eigen::MatrixXd& covariance);
  // Standard deviations: of gravity's direction [rad] (the larger of two), of t_d [s].
  double gravity_sigma() const;
  double time_offset_sigma() const;
  // The same in a world that was turned: p_new = q p_old.
  InertialPrior Turned(const Eigen::Quaterniond& q) const;
};

// The camera after the motion that an IMU measured. What is unknown of T_BC is unknown of the body
// as well, for the images have seen the camera: not counted twice.
CameraPoseEstimate PredictCamera(const InertialPrior& from, const Pose& T_BC,
                                 const ImuPreintegration& imu, double weight = 1.0);

// 6 x 6, of tangents: how the body's pose follows from T_BC where it is known by its camera's
// alone.
Eigen::Matrix<double, 6, 6> BodyByExtrinsics(const Pose& T_WB, const Pose& T_BC);

// The camera's motion, in its own frame, while its body has that state and turns at omega_B
// [rad/s], free of bias.
Twist CameraMotion(const ImuState& body, const Eigen::Vector3d& omega_B, const Pose& T_BC);

}  // namespace highwall
