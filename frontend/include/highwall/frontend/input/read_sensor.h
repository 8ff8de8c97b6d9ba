#pragma once

#include <filesystem>

#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// Reads a calibration.yaml, which `highwall calibrate` writes, with these keys:
//   camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}   # k1 k2 p1 p2 k3
//   sensor: kinect1         # optional; the SensorProfile that provides the defaults of all below
//   depth_factor: 5000      # optional if there is a sensor
//   depth_range: {min: 0.4, max: 10}   # [m] optional
//   depth_noise: {offset: 0.0012, quadratic: 0.0019, reference: 0.4}   # optional: that of a Kinect
//   depth_noise: {baseline: 0.05, focal: 385, subpixel: 0.08}   # or that of DepthNoise::Stereo()
//   colour: {readout: 0.025}           # [s] optional: FrameTiming
//   depth: {delay: 0, readout: 0.025, inverse_offset: 0,   # [s, s, 1/m] optional: RgbdSensor
//           pattern: [20 numbers]}                         # [1/m] DepthPattern, row by row
//   imu: {T_BC: [16 numbers, row by row], gyroscope_noise, accelerometer_noise, gyroscope_walk,
//         accelerometer_walk, rate, time_offset}        # each key optional: see ImuCalibration
//   gps: {antenna: [x, y, z]}   # [m] optional: SensorCalibration::antenna_B
// Throws IoError for an unreadable file, an unknown or missing key, a wrong type, or a value out of
// range.
SensorCalibration ReadSensor(const std::filesystem::path& path);

}  // namespace highwall
