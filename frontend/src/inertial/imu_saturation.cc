#include "inertial/imu_saturation.h"

#include <cmath>
#include <cstddef>

#include <highwall/core/stamp.h>

namespace highwall {
namespace {

constexpr double kAtTheEnd = 0.999;  // of the range: readings are rounded
constexpr double kBeyond = 0.5;      // sigma, as a share of the range

// Returns the time [s] that the saturated readings of one sensor stand for: half of the adjacent
// steps.
double SaturatedTime(std::span<const ImuSample> samples, Eigen::Vector3d ImuSample::*reading,
                     double range) {
  double time = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double half = 0.5 * ToSeconds(samples[i].stamp - samples[i - 1].stamp);
    time += half * (EndsAt(samples[i - 1].*reading, range) + EndsAt(samples[i].*reading, range));
  }
  return time;
}

}  // namespace

bool EndsAt(const Eigen::Vector3d& reading, double range) {
  return reading.cwiseAbs().maxCoeff() >= kAtTheEnd * range;
}

bool IsSaturated(const ImuSample& sample, const ImuCalibration& calibration) {
  return EndsAt(sample.gyroscope, calibration.gyroscope_range) ||
         EndsAt(sample.accelerometer, calibration.accelerometer_range);
}

ImuNoise SaturatedNoise(const ImuNoise& noise, std::span<const ImuSample> samples,
                        const ImuCalibration& calibration) {
  const double root = std::sqrt(ToSeconds(samples.back().stamp - samples.front().stamp));
  const auto join = [&](double density, Eigen::Vector3d ImuSample::*reading, double range) {
    if (!std::isfinite(range)) return density;
    return std::hypot(density, kBeyond * range * SaturatedTime(samples, reading, range) / root);
  };
  ImuNoise saturated = noise;
  saturated.gyroscope = join(noise.gyroscope, &ImuSample::gyroscope, calibration.gyroscope_range);
  saturated.accelerometer =
      join(noise.accelerometer, &ImuSample::accelerometer, calibration.accelerometer_range);
  return saturated;
}

}  // namespace highwall
