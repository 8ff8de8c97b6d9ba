#include <highwall/factors/imu_noise_estimation.h>

#include <algorithm>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/median.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr double kGap = 1.5;              // steps; a reading is missing
constexpr std::size_t kFewReadings = 10;  // of a window: its variance means nothing

double MedianStep(std::span<const ImuSample> samples) {
  std::vector<Stamp> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    HIGHWALL_REQUIRE(samples[i].stamp > samples[i - 1].stamp, "stamps do not increase");
    steps.push_back(samples[i].stamp - samples[i - 1].stamp);
  }
  return ToSeconds(UpperMedian(steps));
}

bool HasGap(std::span<const ImuSample> samples, double step) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (ToSeconds(samples[i].stamp - samples[i - 1].stamp) > kGap * step) return true;
  }
  return false;
}

// Of both sensors, mean over the axes.
struct Variances {
  double gyroscope = 0.0, accelerometer = 0.0;
};

Variances VariancesOf(std::span<const ImuSample> samples) {
  const auto variance = [&](Eigen::Vector3d ImuSample::*part) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : samples) mean += sample.*part;
    mean /= static_cast<double>(samples.size());
    double sum = 0.0;
    for (const ImuSample& sample : samples) sum += (sample.*part - mean).squaredNorm();
    return sum / (3.0 * static_cast<double>(samples.size() - 1));
  };
  return {variance(&ImuSample::gyroscope), variance(&ImuSample::accelerometer)};
}

struct Window {
  ReadingRange range;
  Variances variances;
};

// Windows one after the other that could be at rest: those that IsStationary, without a gap.
std::vector<Window> StationaryWindows(std::span<const ImuSample> samples, std::size_t readings,
                                      double step, const StationaryOptions& options) {
  std::vector<Window> windows;
  for (std::size_t begin = 0; begin + readings <= samples.size(); begin += readings) {
    const auto part = samples.subspan(begin, readings);
    if (HasGap(part, step) || !IsStationary(part, options)) continue;
    windows.push_back({{begin, begin + readings}, VariancesOf(part)});
  }
  return windows;
}

// What a tenth of the windows stays below.
Variances Quiet(const std::vector<Window>& windows) {
  const auto tenth = [&](double Variances::*part) {
    std::vector<double> values;
    for (const Window& window : windows) values.push_back(window.variances.*part);
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  return {tenth(&Variances::gyroscope), tenth(&Variances::accelerometer)};
}

std::vector<double> Axis(std::span<const ImuSample> samples, const ReadingRange& range,
                         Eigen::Vector3d ImuSample::*part, int axis) {
  std::vector<double> values;
  for (std::size_t i = range.begin; i < range.end; ++i) values.push_back((samples[i].*part)[axis]);
  return values;
}

SensorNoise Estimate(std::span<const ImuSample> samples, std::span<const ReadingRange> rest,
                     double step, Eigen::Vector3d ImuSample::*part,
                     const ImuNoiseEstimationOptions& options) {
  const AllanFitOptions fit{.min_tau = (options.min_readings - 0.5) * step,
                            .model_error = options.model_error};
  SensorNoise noise;
  std::vector<std::vector<double>> all;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::vector<double>> stretches;
    for (const ReadingRange& range : rest) {
      stretches.push_back(Axis(samples, range, part, axis));
    }
    noise.axes[static_cast<std::size_t>(axis)] =
        FitAllanCurve(AllanDeviation(stretches, step), fit);
    std::ranges::move(stretches, std::back_inserter(all));
  }
  noise.curve = AllanDeviation(all, step);
  noise.all = FitAllanCurve(noise.curve, fit);
  return noise;
}

}  // namespace

void ImuNoiseEstimationOptions::Validate() const {
  stationary.Validate();
  HIGHWALL_REQUIRE(max_variance_ratio > 1.0,
                   "ImuNoiseEstimationOptions::max_variance_ratio must be above 1");
  RequirePositiveFinite(window, "ImuNoiseEstimationOptions::window");
  RequirePositiveFinite(min_duration, "ImuNoiseEstimationOptions::min_duration");
  RequireAtLeast(min_readings, 1, "ImuNoiseEstimationOptions::min_readings");
  RequireNotNegativeFinite(model_error, "ImuNoiseEstimationOptions::model_error");
}

std::vector<ReadingRange> FindRest(std::span<const ImuSample> samples,
                                   const ImuNoiseEstimationOptions& options) {
  options.Validate();
  if (samples.size() < 2) return {};
  const double step = MedianStep(samples);
  const auto readings = static_cast<std::size_t>(options.window / step) + 1;
  if (readings < kFewReadings) return {};
  StationaryOptions stationary = options.stationary;
  stationary.min_duration = 0.5 * options.window;  // every window is long enough
  const auto windows = StationaryWindows(samples, readings, step, stationary);
  if (windows.empty()) return {};
  const Variances quiet = Quiet(windows);

  std::vector<ReadingRange> rest;
  for (const Window& window : windows) {
    if (window.variances.gyroscope > options.max_variance_ratio * quiet.gyroscope ||
        window.variances.accelerometer > options.max_variance_ratio * quiet.accelerometer) {
      continue;
    }
    const bool joins = !rest.empty() && rest.back().end == window.range.begin &&
                       !HasGap(samples.subspan(window.range.begin - 1, 2), step);
    if (joins) {
      rest.back().end = window.range.end;
    } else {
      rest.push_back(window.range);
    }
  }
  std::erase_if(rest, [&](const ReadingRange& range) {
    return static_cast<double>(range.end - range.begin) * step < options.min_duration;
  });
  return rest;
}

ImuNoiseEstimate EstimateImuNoise(std::span<const ImuSample> samples,
                                  std::span<const ReadingRange> rest,
                                  const ImuNoiseEstimationOptions& options) {
  options.Validate();
  std::size_t longest = 0;
  for (const ReadingRange& range : rest) {
    HIGHWALL_REQUIRE(range.begin <= range.end && range.end <= samples.size(),
                     "a stretch of rest lies outside of the readings");
    longest = std::max(longest, range.end - range.begin);
  }
  // Three octaves, the longest a third of the stretch.
  const auto needed = static_cast<std::size_t>(12 * options.min_readings);
  HIGHWALL_REQUIRE(longest >= needed, "the longest rest has " + std::to_string(longest) +
                                          " readings, at least " + std::to_string(needed) +
                                          " are needed");
  const double step = MedianStep(samples);
  return {.step = step,
          .gyroscope = Estimate(samples, rest, step, &ImuSample::gyroscope, options),
          .accelerometer = Estimate(samples, rest, step, &ImuSample::accelerometer, options)};
}

}  // namespace highwall
