#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>

#include <highwall/frontend/features/twist.h>

namespace highwall {

// Row offsets of position, rotation, velocity, biases and, after the 15 rows of the state,
// gravity's direction in a joint covariance of an inertial state.
namespace state_rows {
inline constexpr int kP = 0, kTheta = 3, kV = 6, kB = 9, kN = 15;
}

// Propagates the estimate by the motion that an IMU measured and adds its noise (Forster et al.
// 2017), inflated if the IMU's residual weighs less than 1 (weight > 0).
InertialEstimate Propagate(const InertialEstimate& from, const ImuPreintegration& imu,
                           const Eigen::Vector3d& gravity_W, double weight = 1.0);

// Pose of the camera and its 6 x 6 covariance in the tangent of PoseManifold.
struct CameraPoseEstimate {
  Pose T_WC;
  Eigen::Matrix<double, 6, 6> covariance;
};
CameraPoseEstimate CameraOf(const InertialEstimate& body, const Pose& T_BC);

// Returns the 15 x 15 state transition: the Jacobian of the state at the end of an interval by that
// at its beginning.
Eigen::Matrix<double, 15, 15> Transition(const InertialEstimate& from,
                                         const ImuPreintegration& imu);

// Initial state of a window: the first state and the calibration, with their joint covariance. At
// rest gravity's direction and the bias of the accelerometer are known jointly much better than
// either: their correlation must not be lost.
struct InertialPrior {
  InertialEstimate estimate;
  UnitDirection gravity_W;
  double time_offset = 0.0;  // [s] t_d
  std::optional<Pose> T_BC;  // if it is an unknown
  // 3 x 3 of [n t_d], with n in the tangent of UnitDirectionManifold at gravity_W [rad, s]; 9 x 9
  // of [n t_d T_BC], with T_BC in the tangent of PoseManifold, if it is an unknown.
  Eigen::MatrixXd calibration_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  // 15 x 3 or 15 x 9 cross-covariance of the state with these.
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling = Eigen::Matrix<double, 15, 3>::Zero();

  // Returns true if the values are finite; the covariances are not examined.
  bool IsFinite() const;
  // Joint covariance, 18 x 18 or 24 x 24.
  Eigen::MatrixXd Joint() const;
  Eigen::MatrixXd JointWithoutTimeOffset() const;
  void SetJoint(const Eigen::MatrixXd& covariance);
  // Standard deviations of gravity's direction [rad] (the larger of two) and of t_d [s].
  double gravity_sigma() const;
  double time_offset_sigma() const;
  // Returns the prior in a rotated world: p_new = q p_old.
  InertialPrior Turned(const Eigen::Quaterniond& q) const;
};

// Propagates the pose of the camera by the motion that an IMU measured. The uncertainty of T_BC is
// also that of the body, because the images observe the camera: it is not counted twice.
CameraPoseEstimate PredictCamera(const InertialPrior& from, const Pose& T_BC,
                                 const ImuPreintegration& imu, double weight = 1.0);

// Returns the 6 x 6 Jacobian, in tangents, of the body's pose by T_BC if it is known from its
// camera's pose alone.
Eigen::Matrix<double, 6, 6> BodyByExtrinsics(const Pose& T_WB, const Pose& T_BC);

// Returns the camera's motion, in its own frame, for that state of the body and its angular
// velocity omega_B [rad/s], free of bias.
Twist CameraMotion(const ImuState& body, const Eigen::Vector3d& omega_B, const Pose& T_BC);

// Returns the camera's motion, in its own frame, at the first of these readings: the velocity with
// which they lead from the body's pose T_WB there to p_WB at their end. gravity_W: [m/s^2].
Twist CameraMotionBefore(const ImuPreintegration& imu, const ImuBias& bias,
                         const Eigen::Vector3d& gravity_W, const Pose& T_WB,
                         const Eigen::Vector3d& p_WB, const Pose& T_BC);

}  // namespace highwall
