#include "inertial/imu_vibration.h"

#include <cmath>

#include <highwall/core/stamp.h>

namespace highwall {

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
  const double step = duration / static_cast<double>(samples.size() - 1);
  const double velocity = share * AccelerometerShake(samples) * step;  // [m/s]
  ImuNoise shaken = noise;
  shaken.accelerometer = std::hypot(noise.accelerometer, velocity / std::sqrt(duration));
  return shaken;
}

}  // namespace highwall
