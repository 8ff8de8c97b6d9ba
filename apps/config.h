#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// Everything a run can be told by a YAML file.
struct RunConfig {
  RgbdSensor sensor{};
  std::optional<ImuCalibration> imu{};  // empty: the file says nothing about an IMU
  // [m] of a GPS, in the frame of the IMU, of the camera where there is none.
  Eigen::Vector3d antenna_B = Eigen::Vector3d::Zero();
};

// Reads
//   camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}   # k1 k2 p1 p2 k3
//   sensor: kinect1         # may be absent; a SensorProfile that all below is taken from
//   depth_factor: 5000      # may be absent where there is a sensor
//   depth_range: {min: 0.4, max: 10}   # [m] may be absent
//   depth_noise: {offset: 0.0012, quadratic: 0.0019, reference: 0.4}   # may be absent: a Kinect's
//   depth_noise: {baseline: 0.05, focal: 385, subpixel: 0.08}   # or that of DepthNoise::Stereo()
//   colour: {readout: 0.025}           # [s] may be absent: FrameTiming
//   depth: {delay: 0, readout: 0.025, inverse_offset: 0,   # [s, s, 1/m] may be absent: RgbdSensor
//           pattern: [20 numbers]}                         # [1/m] DepthPattern, row by row
//   imu: {T_BC: [16 numbers, row by row], gyroscope_noise, accelerometer_noise, gyroscope_walk,
//         accelerometer_walk, rate, time_offset}        # and each of its keys: see ImuCalibration
//   gps: {antenna: [x, y, z]}   # [m] may be absent: RunConfig::antenna_B
// Throws IoError for a file that cannot be read, an unknown or missing key, a wrong type, and a
// value out of range.
RunConfig LoadConfig(const std::filesystem::path& path);

struct ResolvedConfig {
  RunConfig config;
  std::string origin;  // for people: where it came from
};

// choice: what --config says: tum1, tum2, tum3, a file, or nothing; nothing takes
// calibration.yaml from the dataset's folder, else the preset its name tells.
// Throws IoError as LoadConfig, and where no configuration is found.
ResolvedConfig ResolveConfig(const std::string& choice, const std::filesystem::path& dataset);

// The choice that a run was made with (what --config says of it), from "calibration" in its
// run.json; empty where its dataset says, and where the file is not there any more.
std::string ConfigOfRun(const std::string& calibration);

// "tum1" for a folder, or an original recording named in its rgb.txt, that is called freiburg1 (or
// fr1_...), and so on; empty if neither is.
std::string PresetFromName(const std::filesystem::path& dataset);

// calibration.yaml in the folder of a dataset.
std::filesystem::path CalibrationFile(const std::filesystem::path& dataset);

}  // namespace highwall::apps
