#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <highwall/factors/allan_deviation.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/zero_velocity.h>

namespace [[gnu::visibility("default")]] highwall {

struct ImuNoiseEstimationOptions {
  StationaryOptions stationary = {};  // rest, at most
  // > 1; a window rests where its variance is at most so many times that of the quietest: what lies
  // in a hand that is held still does not
  double max_variance_ratio = 2.0;
  double window = 0.5;        // [s] > 0; rests as a whole or not
  double min_duration = 3.0;  // [s] > 0; shorter rests are not used
  int min_readings = 4;       // >= 1; the shortest averaging time that is used
  double model_error = 0.05;  // as AllanFitOptions

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Readings [begin, end).
struct ReadingRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Of a sensor with three axes.
struct SensorNoise {
  std::vector<AllanPoint> curve;       // root mean square of the axes
  NoiseDensities all;                  // fitted to it
  std::array<NoiseDensities, 3> axes;  // x, y, z
};

struct ImuNoiseEstimate {
  double step = 0.0;          // [s] mean between readings
  SensorNoise gyroscope;      // rad/s
  SensorNoise accelerometer;  // m/s^2
};

// Where the sensor rests, in order. samples: strictly increasing stamps. A gap in the readings ends
// a rest. Throws InvalidArgument on bad options.
std::vector<ReadingRange> FindRest(std::span<const ImuSample> samples,
                                   const ImuNoiseEstimationOptions& options = {});

// The densities of ImuNoise from readings at rest, such as FindRest() finds: a minute of it shows
// the white noise, hours the walk of the biases; a gap parts a stretch. samples: strictly increasing stamps. Throws
// InvalidArgument where no stretch of rest has 12 times min_readings, for a stretch outside of the
// samples, and on bad options.                   docs/factors/imu_noise_estimation.md, Eq. 1
ImuNoiseEstimate EstimateImuNoise(std::span<const ImuSample> samples,
                                  std::span<const ReadingRange> rest,
                                  const ImuNoiseEstimationOptions& options = {});

}  // namespace highwall
