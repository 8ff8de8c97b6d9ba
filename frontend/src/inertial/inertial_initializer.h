#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/inertial_prior.h"
#include "inertial/visual_pose.h"

namespace highwall {

enum class InitializationStatus {
  kTooShort,      // images with a pose over less than min_duration
  kNoImu,         // readings are missing, or were so less than min_duration ago
  kUncertain,     // gravity is not known well enough yet
  kWrongGravity,  // the readings' gravity is not 9.81 m/s^2: their unit?
  kInconsistent,  // images and IMU contradict each other: extrinsics, clocks, sign of an axis?
  kReady,
};
const char* ToString(InitializationStatus status);

struct InitializationReport {
  InitializationStatus status = InitializationStatus::kTooShort;
  double duration = 0.0;       // [s] of the images that were used
  double gravity_norm = 0.0;   // [m/s^2] as measured
  double reading_norm = 0.0;   // [m/s^2] median of the accelerometer's readings, in kWrongGravity
  double gravity_sigma = 0.0;  // [rad]
  double error = 0.0;          // chi-squared per degree of freedom
  // In kReady, and in kUncertain and kInconsistent where the images leave no direction open: the
  // newest state, biases, gravity, t_d.
  std::optional<InertialPrior> estimate;
};

// Finds gravity's direction, the biases, the time offset and the velocity from the poses of some
// seconds of images, whose scale depth makes metric, and the IMU between them; at rest or moving.
// Each solution is a least-squares problem over all of them (ImuGravityFactor, CameraPose).
// Source: after Mur-Artal, Tardos, "Visual-inertial monocular SLAM with map reuse", RA-L 2(2),
// 2017, section IV, with the scale known and everything solved at once.
class InertialInitializer {
 public:
  // extrinsics_sigma: of the calibration's T_BC [m, rad], in the tangent of PoseManifold, where it
  // is an unknown. Throws InvalidArgument on bad options.
  InertialInitializer(
      const ImuCalibration& calibration, const InertialInitializerOptions& options,
      bool free_time_offset,
      const std::optional<Eigen::Matrix<double, 6, 1>>& extrinsics_sigma = std::nullopt);

  // An image's pose; stamp [ns] of the camera's clock, ascending.
  void Add(Stamp stamp, const VisualPose& visual);
  void Clear() { images_.clear(); }
  // The map was moved, T_new_old in W, and the images' poses with it.
  void MoveMap(const Pose& T_new_old);

  InitializationReport Solve(const ImuBuffer& imu) const;

 private:
  struct Image {
    Stamp stamp;
    VisualPose visual;
  };
  // The one from which on no readings are missing.
  std::size_t FirstImage(const ImuBuffer& imu, double time_offset) const;
  // [rad] of gravity's direction, to start with. What is unknown of the camera's turn is a tilt of
  // the map, until the body turns.
  double MaxGravitySigma() const;

  ImuCalibration calibration_;
  InertialInitializerOptions options_;
  bool free_time_offset_;
  std::optional<Eigen::Matrix<double, 6, 1>> extrinsics_sigma_;
  std::deque<Image> images_;
};

// [rad/s] the mean reading of the gyroscope within 10 ms of a stamp, bias taken off; zero where
// the buffer does not reach.
Eigen::Vector3d RateAt(const ImuBuffer& imu, Stamp stamp, const ImuBias& bias);

}  // namespace highwall
