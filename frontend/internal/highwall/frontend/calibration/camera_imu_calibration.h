#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

namespace [[gnu::visibility("default")]] highwall {

struct CameraImuCalibrationOptions {
  ImuNoise noise = {};
  // Saturation limit of each axis, as in ImuCalibration.
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s]
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2]
  double interval = 0.1;         // [s] > 0; minimum interval between the camera poses used
  double max_interval = 0.5;     // [s] > interval; poses farther apart are not connected
  double max_time_offset = 0.2;  // [s] > 0; search range
  bool estimate_depth_scale = true;
  // Prior standard deviations.
  double lever_arm_sigma = 0.3;           // [m] > 0, about 0
  double depth_scale_sigma = 0.1;         // > 0, about 1
  double gyroscope_bias_sigma = 0.1;      // [rad/s] > 0, about 0
  double accelerometer_bias_sigma = 0.5;  // [m/s^2] > 0, about 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct CameraImuCalibration {
  Pose T_BC;                                                     // the camera in the body
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();     // [m] of p_BC, along B's axes
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();      // [rad] about C's axes
  double time_offset = 0.0, time_offset_sigma = 0.0;             // [s] t_imu = t_cam + t_d
  double depth_scale = 1.0, depth_scale_sigma = 0.0;             // true = scale * measured
  ImuBias bias = ImuBias::Zero(), bias_sigma = ImuBias::Zero();  // at the midpoint
  double position_error = 0.0, rotation_error = 0.0;  // [m], [rad] RMS per axis of the poses
  int poses = 0;                                      // number of poses used
  // Values that the motion did not observe well, and motions that would; in words, a line each.
  std::vector<std::string> advice;
};

// Calibrates the pose of a camera on an IMU, and the offset of their clocks and metric scales, from
// a recording with rotations about all axes: one batch over all of it. camera: T_WC from the images
// alone, in the clock of the camera, as from `highwall slam --imu off`; a minute of it. No initial
// guess is needed. Standard deviations are scaled with the scatter of the poses and with the
// correlation time of their errors. Returns empty if camera and readings share less than two
// seconds, if the rotation is too small to determine the axes, and if camera and IMU are
// inconsistent. reason: if not null, output of which of these, one line. Throws InvalidArgument for
// bad options. See docs/calibration.md.
//
// Source: Furgale, Rehder, Siegwart, "Unified temporal and spatial calibration for multi-sensor
// systems", IROS 2013, with preintegrated states for the spline; rotation between the axes: Arun,
// Huang, Blostein, PAMI 9(5), 1987.
std::optional<CameraImuCalibration> CalibrateCameraImu(
    const Trajectory& camera, std::span<const ImuSample> readings,
    const CameraImuCalibrationOptions& options = {}, std::string* reason = nullptr);

}  // namespace highwall
