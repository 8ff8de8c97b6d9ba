#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/zero_velocity.h>
#include <highwall/frontend/calibration/allan_deviation.h>

namespace [[gnu::visibility("default")]] highwall {

struct ImuNoiseEstimationOptions {
  StationaryOptions stationary = {};  // upper bounds for a stationary window
  // > 1; a window is stationary if its variance is at most this multiple of that of the quiet
  // windows (their lowest tenth), which excludes a sensor held still in a hand
  double max_variance_ratio = 2.0;
  double window = 0.5;        // [s] > 0; length of the windows that are tested
  double min_duration = 3.0;  // [s] > 0; shorter stationary stretches are not used
  int min_readings = 4;       // >= 1; shortest averaging time used, in readings
  double model_error = 0.05;  // as AllanFitOptions

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Range [begin, end) of readings.
struct ReadingRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Noise of a sensor with three axes.
struct SensorNoise {
  std::vector<AllanPoint> curve;       // root mean square of the axes
  NoiseDensities all;                  // fitted to the curve
  std::array<NoiseDensities, 3> axes;  // x, y, z
};

struct ImuNoiseEstimate {
  double step = 0.0;          // [s] mean between readings
  SensorNoise gyroscope;      // rad/s
  SensorNoise accelerometer;  // m/s^2
};

// Returns the stretches in which the sensor is stationary, in order of time. samples: strictly
// increasing stamps. A gap in the readings ends a stretch. Throws InvalidArgument on bad options.
std::vector<ReadingRange> FindRest(std::span<const ImuSample> samples,
                                   const ImuNoiseEstimationOptions& options = {});

// Estimates the densities of ImuNoise from readings at rest, such as those of FindRest(): a minute
// suffices for the white noise, hours are needed for the bias random walk. A gap splits a stretch.
// samples: strictly increasing stamps. Empty if no stretch has 12 times min_readings, or if the
// readings of a sensor never change. Throws InvalidArgument for a stretch outside of the samples,
// and on bad options.
// docs/imu_noise_estimation.md, Eq. 5
std::optional<ImuNoiseEstimate> EstimateImuNoise(std::span<const ImuSample> samples,
                                                 std::span<const ReadingRange> rest,
                                                 const ImuNoiseEstimationOptions& options = {});

}  // namespace highwall
