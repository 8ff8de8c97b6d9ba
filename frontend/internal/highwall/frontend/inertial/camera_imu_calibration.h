#pragma once

#include <limits>
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
  // Where readings of an axis end, as ImuCalibration has it.
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s]
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2]
  double interval = 0.1;         // [s] > 0; poses of the camera are used so far apart, at least
  double max_interval = 0.5;     // [s] > interval; farther apart, nothing ties them
  double max_time_offset = 0.2;  // [s] > 0; as far as it is looked for
  bool estimate_depth_scale = true;
  // Standard deviations before anything is known.
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
  ImuBias bias = ImuBias::Zero(), bias_sigma = ImuBias::Zero();  // in the middle
  double position_error = 0.0, rotation_error = 0.0;  // [m], [rad] RMS of an axis of the poses
  int poses = 0;                                      // that took part
  // What the motion did not tell well, and which motion would; in words, a line each.
  std::vector<std::string> advice;
};

// Where a camera sits on an IMU, how their clocks and their metres differ, from a recording with
// turns about all axes: one batch over all of it. camera: T_WC by the images alone, in the clock of
// the camera, such as `highwall slam --imu off` gives; a minute of it. No guess is needed.
// Standard deviations grow with what the poses scatter and with how long an error of theirs lasts.
// Throws InvalidArgument, saying so, where camera and readings share less than two seconds, where
// the motion turns too little for the axes to be told, where they contradict each other, and on bad
// options.                                                                      docs/calibration.md
//
// Source: Furgale, Rehder, Siegwart, "Unified temporal and spatial calibration for multi-sensor
// systems", IROS 2013, with preintegrated states for the spline; rotation between the axes: Arun,
// Huang, Blostein, PAMI 9(5), 1987.
CameraImuCalibration CalibrateCameraImu(const Trajectory& camera,
                                        std::span<const ImuSample> readings,
                                        const CameraImuCalibrationOptions& options = {});

}  // namespace highwall
