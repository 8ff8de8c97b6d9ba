#pragma once

#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/factors/imu_preintegration.h>

namespace [[gnu::visibility("default")]] highwall {

// When the rows of the two images are taken (docs/row_times.md). The time of an image is that of
// its middle row; a read-out goes from the first row to the last, 0 where all are taken at once.
struct FrameTiming {
  double colour_readout = 0.0;  // [s] >= 0
  double depth_readout = 0.0;   // [s] >= 0
  double depth_delay = 0.0;     // [s] by which depth is later than the stamps of the images say

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What a sequence tells of it; sigma: standard deviations.
struct FrameTimingEstimate {
  FrameTiming value{}, sigma{};
};

// An RGB-D camera whose depth image is registered to its colour image: one pinhole for both. The
// default range is that of no sensor in particular: the noise decides what a reading is worth.
struct RgbdSensor {
  PinholeCamera camera{};
  // How a stored value becomes metres, MetricDepth(): the value that stands for one metre, and by
  // how much the inverse of what that makes is too large, everywhere and from place to place.
  // SlamSystem is given metres, and uses none of them.
  double depth_factor = 5000.0;       // [1/m] > 0
  double inverse_depth_offset = 0.0;  // [1/m] within 1: below 0 where depth reads too long
  DepthPattern depth_pattern{};       // over the image as it is stored, not undistorted
  DepthNoise depth_noise{};           // of the metric depth
  double min_depth = 0.05;            // [m] > 0; a nearer reading is none
  double max_depth = 20.0;            // [m] > min_depth; neither is a farther one
  FrameTiming timing{};               // where it is known; SlamSystem finds out more

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The sensors of the TUM RGB-D benchmark (Sturm et al., "A Benchmark for the Evaluation of RGB-D
// SLAM Systems", IROS 2012; ROS default calibrations of its file formats page): "tum1", "tum2" and
// "tum3" for freiburg1, 2 and 3, with the depth of "kinect1" (docs/sensors.md). Empty for any other
// name.
std::optional<RgbdSensor> SensorPreset(std::string_view name);

// The names SensorPreset knows, in order.
std::vector<std::string_view> SensorPresetNames();

// An IMU that is fixed to a camera.
struct ImuCalibration {
  Pose T_BC;                 // the camera in the body frame, whose axes are those of the IMU
  ImuNoise noise{};          // of the readings
  double rate = 200.0;       // [Hz] > 0; nominal
  double time_offset = 0.0;  // [s] in [-1, 1]; a first guess of t_d: t_imu = t_cam + t_d
  // Where readings of an axis end: what is faster or stronger is read as this. Infinite where
  // nobody said. In (0, kMaxAngularRate], and at least gravity's, which any sensor reads at rest.
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s]
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2]

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
