#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/inertial/visual_pose.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/inertial_prior.h"

namespace highwall {

// Maximum relative error of the magnitude of gravity.
inline constexpr double kMaxGravityError = 0.06;

// Criteria of the initialization that are no options of a user.
struct InitializationCriteria {
  double max_duration = 8.0;  // [s] > 1; older images are discarded
  // [rad] > 0; uncertainty of gravity's direction below which initialization succeeds. At rest the
  // bias of the accelerometer and a tilt are indistinguishable: 0.1 m/s^2 are 0.01 rad.
  double max_gravity_sigma = 0.015;
};

enum class InitializationStatus {
  kTooShort,      // images with a pose over less than a second
  kNoImu,         // readings are missing, or were missing less than a second ago
  kUncertain,     // gravity is not accurate enough yet
  kWrongGravity,  // gravity from the readings is not 9.81 m/s^2: their unit?
  kInconsistent,  // images and IMU are inconsistent: extrinsics, clocks, sign of an axis?
  kReady,
};
const char* ToString(InitializationStatus status);

// Whether the readings fit the images better with the sign of the accelerometer reversed.
enum class ReversedFit { kNotBetter, kBetter, kClearlyBetter };

struct InitializationReport {
  InitializationStatus status = InitializationStatus::kTooShort;
  double duration = 0.0;       // [s] covered by the images used
  double gravity_norm = 0.0;   // [m/s^2] as measured
  double reading_norm = 0.0;   // [m/s^2] median of the accelerometer's readings, in kWrongGravity
  double gravity_sigma = 0.0;  // [rad]
  double error = 0.0;          // chi-squared per degree of freedom
  ReversedFit reversed = ReversedFit::kNotBetter;
  // In kReady, and in kUncertain and kInconsistent if every direction is observable: the newest
  // state, biases, gravity, t_d.
  std::optional<InertialPrior> estimate;
};

// Estimates gravity's direction, the biases, the time offset and the velocity from the poses of a
// few seconds of images, metric by their depth, and the IMU between them; at rest or in motion.
// Each solution is a least-squares problem over all of them (ImuGravityFactor, CameraPose). Source:
// after Mur-Artal, Tardos, "Visual-inertial monocular SLAM with map reuse", RA-L 2(2), 2017,
// section IV, with known scale and all unknowns solved jointly.
class InertialInitializer {
 public:
  // extrinsics_sigma: of the calibration's T_BC [m, rad], in the tangent of PoseManifold, if T_BC
  // is an unknown. Throws InvalidArgument on bad options.
  InertialInitializer(
      const ImuCalibration& calibration, const InertialInitializerOptions& options,
      bool free_time_offset,
      const std::optional<Eigen::Matrix<double, 6, 1>>& extrinsics_sigma = std::nullopt,
      const InitializationCriteria& criteria = {});

  // Adds an image's pose; stamp [ns] of the camera's clock, ascending. Returns false and ignores it
  // if the image before is closer than a tenth of a second.
  bool Add(Stamp stamp, const VisualPose& visual);
  void Clear() { images_.clear(); }
  // Transforms the images' poses with the map by T_new_old in W.
  void MoveMap(const Pose& T_new_old);

  InitializationReport Solve(const ImuBuffer& imu) const;

 private:
  struct Image {
    Stamp stamp;
    VisualPose visual;
  };
  // Returns the index of the first image after the latest gap in the readings.
  std::size_t FirstImage(const ImuBuffer& imu, double time_offset) const;
  // Returns the limit of the sigma of gravity's direction [rad] for the initialization. The
  // uncertainty of the camera's rotation in the body acts as a tilt of the map until the body
  // rotates.
  double MaxGravitySigma() const;

  ImuCalibration calibration_;
  InertialInitializerOptions options_;
  InitializationCriteria criteria_;
  bool free_time_offset_;
  std::optional<Eigen::Matrix<double, 6, 1>> extrinsics_sigma_;
  std::deque<Image> images_;
};

// Returns the mean reading of the gyroscope within 10 ms of a stamp, bias removed [rad/s]; zero if
// the buffer does not cover it.
Eigen::Vector3d RateAt(const ImuBuffer& imu, Stamp stamp, const ImuBias& bias);

}  // namespace highwall
