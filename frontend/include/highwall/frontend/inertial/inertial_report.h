#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>

namespace [[gnu::visibility("default")]] highwall {

// A state of the body with its uncertainty.
struct InertialEstimate {
  Stamp stamp = 0;  // of the IMU's clock
  ImuState state;   // T_WB, v_WB
  ImuBias bias = ImuBias::Zero();
  // 15 x 15 of [p theta | v | b_g b_a], p and theta in the tangent of PoseManifold.
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Identity();
};

// Where the camera sits on the body, as it is estimated along (InertialOptions).
struct ExtrinsicsEstimate {
  Pose T_BC;
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();  // [m] of p_BC, along B's axes
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();   // [rad] about C's axes
  // Known twice as well as beforehand, by axis; else the motion has not told much of it.
  std::array<bool, 3> lever_arm_seen{}, rotation_seen{};
};

// What the IMU does for a frame.
enum class InertialStatus {
  kWaiting,        // no readings around the images yet
  kInitializing,   // gravity, biases and velocity are not known yet
  kRunning,        // images and IMU
  kDeadReckoning,  // the IMU alone
  kGivenUp,        // images and IMU contradict each other: the images alone; tried every 5 s
};

// "waiting", "initializing", "running", "dead reckoning", "given up".
const char* ToString(InertialStatus status);

// An update of the window of landmarks (InertialCoupling::kTight).
struct TightUpdate {
  bool accepted = false;      // else that window begins anew from the one of poses
  double milliseconds = 0.0;  // that it took
};

// What became of one image.
struct InertialReport {
  InertialStatus status = InertialStatus::kWaiting;
  std::string reason;               // in kInitializing and kGivenUp: what is amiss, one line
  double weight = 0.0;              // of the interval's IMU factor
  double squared_innovation = 0.0;  // of the image's pose against the prediction
  int innovation_dof = 0;           // 0 where it was not formed
  bool stationary = false;
  bool restarted = false;  // readings were missing before this image, or were contradicted
  // The image contradicts the readings since the one before beyond any noise, as after a blow to
  // the sensor: they are not used, nor is what keyframes would be tied by over them.
  bool contradicted = false;
  // Some of the readings since the image before end where the sensor does
  // (ImuCalibration::accelerometer_range): they count for as little as is known of the truth.
  bool saturated = false;
  // The motion that makes z point up, to be applied to the whole map: a turn about the origin in
  // the report of the image that ends the initialization, and one about the camera later on, where
  // gravity has become known much better than it was then.
  std::optional<Pose> T_level;
  // After the image, once initialized; in W.
  std::optional<InertialEstimate> estimate;
  double gravity_sigma = 0.0;                         // [rad]
  double time_offset = 0.0, time_offset_sigma = 0.0;  // [s] t_d
  std::optional<ExtrinsicsEstimate> extrinsics;       // where they are estimated
  std::optional<TightUpdate> tight;  // the last that ended since the image before, where one did
};

}  // namespace highwall
