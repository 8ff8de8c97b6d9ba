#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/factors/imu_buffer.h>

#include "simulate/random.h"

namespace highwall::simulate {

// Faults of real IMUs in addition to noise and bias random walk. Calibration files do not contain
// them; only the ranges are in data sheets. Values with a sigma are drawn once, independently for
// each axis. All zero: a sensor without faults.
struct ImuFaults {
  double gyroscope_scale = 0.0;      // [1] >= 0, sigma of an axis's scale about 1
  double accelerometer_scale = 0.0;  // [1] >= 0, likewise
  double misalignment = 0.0;         // [rad] in [0, 0.1], sigma of each axis against the two others
  double g_sensitivity = 0.0;        // [rad/s per m/s^2] >= 0, sigma of each of nine
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s] > 0, clips
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2] > 0, clips
  // Biases drift during warm-up by these total sigmas, as 1 - exp(-t / warm_up).
  double gyroscope_drift = 0.0;      // [rad/s] >= 0
  double accelerometer_drift = 0.0;  // [m/s^2] >= 0
  double warm_up = 60.0;             // [s] > 0
  double stamp_jitter = 0.0;         // [s] >= 0, sigma; truncated at a fifth of a period
  double dropped = 0.0;              // [0, 0.5], share of lost readings
  // [s] >= 0, one in each such interval: shocks to the sensor that do not move the camera, half
  // sines of 60 ms up to 40 m/s^2 and 3 rad/s along random axes; 0: none.
  double blow_interval = 0.0;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns the faults of a low-cost sensor in poor conditions: scale 0.5 %, axes 0.3 deg, 0.1 deg/s
// per g, a range of 4 g and 500 deg/s, a warm-up of ten kelvins with the temperature coefficients
// of Bosch's BMI055 (BST-BMI055-DS000: 0.015 deg/s/K, 1 mg/K), stamp errors of 0.2 ms, one reading
// in 200 lost.
ImuFaults HardImuFaults();

// Parses "off", "hard", or name=value,... with the field names of ImuFaults, e.g.
// "gyroscope_scale=0.01,dropped=0.02"; "hard,dropped=0" modifies the hard ones. Throws
// InvalidArgument with the reason.
ImuFaults ParseImuFaults(const std::string& text);

// One sensor with its faults.
class FaultyImu {
 public:
  FaultyImu(const ImuFaults& faults, const CounterRandom& random, double rate);

  // Returns the bias drift [rad/s, m/s^2] t [s] after the sensor was switched on.
  ImuBias DriftAt(double t) const;
  // Applies axes, scales and gravity sensitivity to a reading, before its bias and noise.
  ImuSample Distorted(const ImuSample& ideal) const;
  // Applies shocks, range, stamp errors and losses to the readings with bias and noise, one per
  // sample in their order.
  std::vector<ImuSample> Delivered(std::vector<ImuSample> readings) const;

 private:
  // Returns the effect of a shock on the reading at t [s] since the first.
  ImuBias ShockAt(double t) const;

  ImuFaults faults_;
  CounterRandom random_;
  double rate_;
  Eigen::Matrix3d gyroscope_, accelerometer_, g_sensitivity_;
  ImuBias drift_;
};

}  // namespace highwall::simulate
