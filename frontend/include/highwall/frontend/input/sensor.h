#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/factors/imu_preintegration.h>

namespace [[gnu::visibility("default")]] highwall {

// Where the read-out of both images goes. Rows of the sensor are columns of an image that is stored
// turned by a quarter, as by a phone held upright: kLeft where it is turned clockwise.
enum class ReadoutDirection { kDown, kUp, kRight, kLeft };

// "down", "up", "right" or "left", the names in a calibration.yaml.
const char* ToString(ReadoutDirection direction);
// Returns the direction of this name; empty for any other.
std::optional<ReadoutDirection> ReadoutDirectionOf(std::string_view name);

// Read-out timing of the rows of both images (docs/row_times.md). The time of an image is that of
// its middle row; the read-out lasts from the first row to the last, 0 for a global shutter.
struct FrameTiming {
  double colour_readout = 0.0;  // [s] >= 0
  double depth_readout = 0.0;   // [s] >= 0
  double depth_delay = 0.0;     // [s] by which depth is later than the stamps of the images say
  ReadoutDirection direction = ReadoutDirection::kDown;  // from the first row to the last

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Estimate of the frame timing from a sequence; sigma: standard deviations.
struct FrameTimingEstimate {
  FrameTiming value{}, sigma{};
};

// A depth camera beside the colour camera, as in a RealSense, whose depth images were recorded as
// it sees them.
struct DepthCameraCalibration {
  PinholeCamera camera{};  // with its size and distortion
  Pose T_CD{};             // from its frame to that of the colour camera

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// An RGB-D camera whose depth image is registered to its colour image: one pinhole for both. The
// default range is not that of a particular sensor: the noise decides the weight of a reading.
struct RgbdSensor {
  PinholeCamera
      camera{};  // of colour; depth images have its pixels, unless there is a depth_camera
  // Conversion of stored values to metres, MetricDepth(): the value that stands for one metre, and
  // the excess of the resulting inverse depth, constant and varying over the image. SlamSystem
  // expects metres and uses none of them.
  double depth_factor = 5000.0;       // [1/m] > 0
  double inverse_depth_offset = 0.0;  // [1/m] within 1: below 0 where depth reads too long
  DepthPattern depth_pattern{};       // over the raw image, not undistorted
  DepthNoise depth_noise{};           // of the metric depth
  double min_depth = 0.05;            // [m] > 0; nearer readings are invalid
  double max_depth = 20.0;            // [m] > min_depth; farther readings are invalid
  FrameTiming timing{};               // if known; SlamSystem estimates the rest online
  // Depth as recorded, before it is registered to colour: readers of recordings do that.
  std::optional<DepthCameraCalibration> depth_camera{};

  // Throws InvalidArgument naming the field. A focal length below a tenth of the image's side, a
  // principal point outside of the image, and pixels twice as high as wide (or the reverse) are
  // those of no such camera.
  void Validate() const;
};

// Returns a sensor of the TUM RGB-D benchmark (Sturm et al., "A Benchmark for the Evaluation of
// RGB-D SLAM Systems", IROS 2012; ROS default calibrations of its file formats page): "tum1",
// "tum2" and "tum3" for freiburg1, 2 and 3, with the depth of "kinect1" (docs/sensors.md). Empty
// for any other name.
std::optional<RgbdSensor> SensorPreset(std::string_view name);

// The names known to SensorPreset, in order.
std::vector<std::string_view> SensorPresetNames();

// Calibration of an IMU that is rigidly mounted to a camera.
struct ImuCalibration {
  Pose T_BC;                 // the camera in the body frame, whose axes are those of the IMU
  ImuNoise noise{};          // of the readings
  double rate = 200.0;       // [Hz] > 0; nominal
  double time_offset = 0.0;  // [s] in [-1, 1]; initial guess of t_d: t_imu = t_cam + t_d
  // Saturation limit of each axis: a faster or stronger motion reads as this value. Infinite if
  // unknown. In (0, kMaxAngularRate], and at least gravity, which any sensor reads at rest.
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s]
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2]

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Calibration of the sensors of a recording.
struct SensorCalibration {
  RgbdSensor sensor{};
  std::optional<ImuCalibration> imu{};  // empty if none is stated
  // [m] position of the GPS antenna in the IMU frame, or in the camera frame without an IMU.
  Eigen::Vector3d antenna_B = Eigen::Vector3d::Zero();
  // Of a file of another system: what it is, such as "a camera chain of Kalibr", and the keys of
  // calibration.yaml that it does not state, whose values are defaults. Both empty otherwise.
  std::string format{};
  std::vector<std::string> defaults{};
};

// Reads a calibration.yaml, which `highwall calibrate` writes, with these keys:
//   camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}
//           # and of its lens k1, k2, p1, p2, k3, k4, k5, k6 (PinholeCamera), lens: equidistant
//   sensor: kinect1         # optional; the SensorProfile that provides the defaults of all below
//   depth_factor: 5000      # optional if there is a sensor
//   depth_range: {min: 0.4, max: 10}   # [m] optional
//   depth_noise: {offset: 0.0012, quadratic: 0.0019, reference: 0.4}   # optional: that of a Kinect
//   depth_noise: {baseline: 0.05, focal: 385, subpixel: 0.08}   # or that of DepthNoise::Stereo()
//   colour: {readout: 0.025, direction: left}   # [s] optional: FrameTiming; down, up, right, left
//   depth: {delay: 0, readout: 0.025, inverse_offset: 0,   # [s, s, 1/m] optional: RgbdSensor
//           pattern: [20 numbers]}                         # [1/m] DepthPattern, row by row
//   depth_camera: {width, height, fx, fy, cx, cy, k1 and so on, T_CD: [16 numbers, row by row]}
//                             # optional, of depth that is not registered: DepthCameraCalibration
//   imu: {T_BC: [16 numbers, row by row], gyroscope_noise, accelerometer_noise, gyroscope_walk,
//         accelerometer_walk, rate, time_offset}        # each key optional: see ImuCalibration
//   gps: {antenna: [x, y, z]}   # [m] optional: SensorCalibration::antenna_B
// or a calibration of another system, recognized by its content (docs/recordings.md): ORB-SLAM,
// OpenCV, a camera_info of ROS, Kalibr, EuRoC, Open3D. Depth that it does not describe is in
// millimetres. Throws IoError for an unreadable file, an unknown or missing key, a wrong type, a
// value out of range, and a file without the size of the images (see open_dataset.h).
SensorCalibration ReadSensor(const std::filesystem::path& path);

}  // namespace highwall
