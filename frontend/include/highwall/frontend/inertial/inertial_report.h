#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace [[gnu::visibility("default")]] highwall {

// A state of the body with its uncertainty.
struct InertialEstimate {
  Stamp stamp = 0;  // of the IMU's clock
  ImuState state;   // T_WB, v_WB
  ImuBias bias = ImuBias::Zero();
  // 15 x 15 of [p theta | v | b_g b_a], p and theta in the tangent of PoseManifold.
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Identity();
};

// Camera pose on the body (extrinsics), estimated online (InertialOptions).
struct ExtrinsicsEstimate {
  Pose T_BC;
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();  // [m] of p_BC, along B's axes
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();   // [rad] about C's axes
  // Twice as certain as the prior, per axis; otherwise the motion has not observed it well.
  std::array<bool, 3> lever_arm_seen{}, rotation_seen{};
};

// State of the IMU fusion at a frame.
enum class InertialStatus {
  kWaiting,        // no readings around the images yet
  kInitializing,   // gravity, biases and velocity are not known yet
  kRunning,        // images and IMU
  kDeadReckoning,  // the IMU alone
  kGivenUp,        // images and IMU are inconsistent: images only; retried every 5 s
};

// Returns "waiting", "initializing", "running", "dead reckoning" or "given up".
const char* ToString(InertialStatus status);

// Result of an update of the tightly coupled smoother (InertialCoupling::kTight).
struct TightUpdate {
  bool accepted = false;      // false: that smoother restarts from the loosely coupled one
  double milliseconds = 0.0;  // duration of the update
  std::string reason{};       // why it was not accepted, one line
};

// Result of the IMU fusion of one image.
struct InertialReport {
  InertialStatus status = InertialStatus::kWaiting;
  std::string reason;               // in kInitializing and kGivenUp: the cause, one line
  double weight = 0.0;              // of the interval's IMU factor
  double squared_innovation = 0.0;  // of the image's pose against the prediction
  int innovation_dof = 0;           // 0 if it was not computed
  bool stationary = false;
  bool restarted = false;  // readings were missing before this image, or were inconsistent
  // The image is inconsistent with the readings since the one before beyond any noise, as after a
  // shock to the sensor: tracking does not use them, nor are there IMU factors between keyframes
  // over them. The final smoothing weighs them down where refined poses contradict them as well.
  bool contradicted = false;
  // Some of the readings since the image before are saturated
  // (ImuCalibration::accelerometer_range): they are weighted by how little they say of the true
  // value.
  bool saturated = false;
  // The images contradict the configuration of the IMU (docs/misconfiguration.md, IMU).
  std::optional<SensorFinding> finding{};
  // The IMU was in use until this image and is given up for that reason: nothing of it is to be
  // kept, such as IMU factors between keyframes.
  bool abandoned = false;
  // Gravity alignment: the transform that makes z point up, to be applied to the whole map: a
  // rotation about the origin in the report of the image that ends the initialization, and one
  // about the camera later, when gravity has become known much better than it was then.
  std::optional<Pose> T_gravity;
  // State after the image, once initialized; in W.
  std::optional<InertialEstimate> estimate;
  double gravity_sigma = 0.0;                         // [rad]
  double time_offset = 0.0, time_offset_sigma = 0.0;  // [s] t_d
  std::optional<ExtrinsicsEstimate> extrinsics;       // if they are estimated
  std::optional<TightUpdate> tight;  // the last that ended since the image before, if any
};

}  // namespace highwall
