#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/factors/imu_buffer.h>

#include "simulate/random.h"

namespace highwall::simulate {

// What real IMUs do beside noise and a bias that walks, and what no calibration file tells, but for
// the ranges, which data sheets do. Values with a sigma are drawn once, for each axis by itself.
// All zero: a sensor without faults.
struct ImuFaults {
  double gyroscope_scale = 0.0;      // [1] >= 0, sigma of an axis's scale about 1
  double accelerometer_scale = 0.0;  // [1] >= 0, likewise
  double misalignment = 0.0;         // [rad] in [0, 0.1], sigma of each axis against the two others
  double g_sensitivity = 0.0;        // [rad/s per m/s^2] >= 0, sigma of each of nine
  double gyroscope_range = std::numeric_limits<double>::infinity();      // [rad/s] > 0: no more
  double accelerometer_range = std::numeric_limits<double>::infinity();  // [m/s^2] > 0: is read
  // Biases drift while the sensor warms up, by these sigmas in all, as 1 - exp(-t / warm_up).
  double gyroscope_drift = 0.0;      // [rad/s] >= 0
  double accelerometer_drift = 0.0;  // [m/s^2] >= 0
  double warm_up = 60.0;             // [s] > 0
  double stamp_jitter = 0.0;         // [s] >= 0, sigma; cut off at a fifth of a period
  double dropped = 0.0;              // [0, 0.5], share of the readings that never arrive
  // [s] >= 0, one in each such span of time: blows to the sensor that move no camera, half sines of
  // 60 ms up to 40 m/s^2 and 3 rad/s along axes that are drawn; 0: none.
  double blow_interval = 0.0;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A cheap sensor on a bad day: scale 0.5 %, axes 0.3 deg, 0.1 deg/s per g, a range of 4 g and
// 500 deg/s, ten kelvins of warming up at the temperature coefficients of Bosch's BMI055
// (BST-BMI055-DS000: 0.015 deg/s/K, 1 mg/K), stamps off by 0.2 ms, one reading in 200 lost.
ImuFaults HardImuFaults();

// "off", "hard", or name=value,... with the fields of ImuFaults by name, e.g.
// "gyroscope_scale=0.01,dropped=0.02"; "hard,dropped=0" changes the hard ones. Throws
// InvalidArgument saying what is wrong with it.
ImuFaults ParseImuFaults(const std::string& text);

// One sensor with its faults.
class FaultyImu {
 public:
  FaultyImu(const ImuFaults& faults, const CounterRandom& random, double rate);

  // [rad/s, m/s^2] what the bias has drifted by, t [s] after it was switched on.
  ImuBias DriftAt(double t) const;
  // What the sensor makes of a reading before its bias and noise: axes, scales, gravity.
  ImuSample Distorted(const ImuSample& ideal) const;
  // What becomes of the readings with bias and noise, one each, in their order: blows, range,
  // stamps, those that arrive.
  std::vector<ImuSample> Delivered(std::vector<ImuSample> readings) const;

 private:
  // What a blow adds to the reading at t [s] since the first.
  ImuBias BlowAt(double t) const;

  ImuFaults faults_;
  CounterRandom random_;
  double rate_;
  Eigen::Matrix3d gyroscope_, accelerometer_, g_sensitivity_;
  ImuBias drift_;
};

}  // namespace highwall::simulate
