#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// Returns readings with white noise [unit / sqrt(Hz)] and a random walk of the bias [unit / s /
// sqrt(Hz)].
inline std::vector<double> NoisyReadings(unsigned seed, std::size_t count, double hertz,
                                         double white, double walk) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  std::vector<double> readings;
  double bias = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    readings.push_back(bias + white * std::sqrt(hertz) * normal(rng));
    bias += walk / std::sqrt(hertz) * normal(rng);
  }
  return readings;
}

// Returns the readings of an IMU that is stationary for this duration [s], including its biases and
// gravity.
inline std::vector<ImuSample> ImuAtRest(unsigned seed, double duration, double hertz,
                                        const ImuNoise& noise) {
  const auto count = static_cast<std::size_t>(duration * hertz);
  std::vector<ImuSample> samples(count);
  for (int axis = 0; axis < 3; ++axis) {
    const auto own = static_cast<unsigned>(axis);
    const auto gyroscope =
        NoisyReadings(6 * seed + own, count, hertz, noise.gyroscope, noise.gyroscope_walk);
    const auto accelerometer = NoisyReadings(6 * seed + 3 + own, count, hertz, noise.accelerometer,
                                             noise.accelerometer_walk);
    for (std::size_t i = 0; i < count; ++i) {
      samples[i].gyroscope[axis] = 0.01 * (axis - 1) + gyroscope[i];
      samples[i].accelerometer[axis] = (axis == 2 ? 9.81 : 0.05) + accelerometer[i];
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    samples[i].stamp = static_cast<Stamp>(std::llround(1e9 * static_cast<double>(i) / hertz));
  }
  return samples;
}

}  // namespace highwall
