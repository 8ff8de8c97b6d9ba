#include "inertial/imu_vibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include <highwall/core/stamp.h>

namespace highwall {
namespace {

constexpr double kGap = 1.5;  // multiple of the median step: a longer one misses a reading

struct MissingReadings {
  std::size_t readings = 0;
  // Variance of the sum of their substitutes, in units of the vibration's variance.
  double squared_errors = 0.0;
};

MissingReadings FindMissing(std::span<const ImuSample> samples) {
  std::vector<Stamp> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    steps.push_back(samples[i].stamp - samples[i - 1].stamp);
  }
  MissingReadings missing;
  if (steps.size() < 4) return missing;  // nothing to compare with
  // The first and last steps may be short, as an interval may be cut between two readings.
  std::vector<Stamp> inner(steps.begin() + 1, steps.end() - 1);
  const auto middle = inner.begin() + (std::ssize(inner) - 1) / 2;
  std::ranges::nth_element(inner, middle);
  const double usual = ToSeconds(*middle);
  for (const Stamp step : steps) {
    if (!(ToSeconds(step) > kGap * usual)) continue;
    const double count = std::round(ToSeconds(step) / usual) - 1.0;
    missing.readings += static_cast<std::size_t>(count);
    // Each has an error of its own, and all share the errors of the two neighbours that replace
    // them.
    missing.squared_errors += count + 0.5 * count * count;
  }
  return missing;
}

}  // namespace

double AccelerometerShake(std::span<const ImuSample> samples) {
  if (samples.size() < 3) return 0.0;
  double squares = 0.0;
  for (std::size_t i = 2; i < samples.size(); ++i) {
    squares += (samples[i].accelerometer - 2.0 * samples[i - 1].accelerometer +
                samples[i - 2].accelerometer)
                   .squaredNorm();
  }
  // A second difference of white noise has six times its variance; three axes.
  return std::sqrt(squares / (18.0 * static_cast<double>(samples.size() - 2)));
}

ImuNoise ShakenNoise(const ImuNoise& noise, std::span<const ImuSample> samples, double share) {
  const double duration = ToSeconds(samples.back().stamp - samples.front().stamp);
  const MissingReadings missing = FindMissing(samples);
  const double step = duration / static_cast<double>(samples.size() - 1 + missing.readings);
  const double shake = AccelerometerShake(samples);
  const double velocity = std::hypot(share * shake * step,
                                     shake * step * std::sqrt(missing.squared_errors));  // [m/s]
  ImuNoise shaken = noise;
  shaken.accelerometer = std::hypot(noise.accelerometer, velocity / std::sqrt(duration));
  return shaken;
}

}  // namespace highwall
