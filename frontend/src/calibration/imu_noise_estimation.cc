#include <highwall/frontend/calibration/imu_noise_estimation.h>

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/median.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr double kGap = 1.8;   // [steps] a longer step is a missing reading, not rounding
constexpr double kHole = 2.5;  // [medians] a longer step is not a sampling interval
constexpr std::size_t kFewReadings = 10;  // in a shorter window the variance is meaningless

// Returns the mean of all steps that are sampling intervals: with rounded stamps, many rates have
// the same median.
double StepOf(std::span<const ImuSample> samples) {
  std::vector<Stamp> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    HIGHWALL_REQUIRE(samples[i].stamp > samples[i - 1].stamp,
                     "the stamps of the readings must increase");
    steps.push_back(samples[i].stamp - samples[i - 1].stamp);
  }
  const double hole = kHole * static_cast<double>(UpperMedian(steps));
  double sum = 0.0, count = 0.0;
  for (const Stamp step : steps) {
    if (static_cast<double>(step) > hole) continue;
    sum += ToSeconds(step);
    ++count;
  }
  return sum / count;
}

bool HasGap(std::span<const ImuSample> samples, double step) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (ToSeconds(samples[i].stamp - samples[i - 1].stamp) > kGap * step) return true;
  }
  return false;
}

// Variances of both sensors, averaged over the axes.
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

// Splits the stretches where readings are missing.
std::vector<ReadingRange> SplitAtGaps(std::span<const ImuSample> samples,
                                      std::span<const ReadingRange> stretches, double step) {
  std::vector<ReadingRange> parts;
  for (const ReadingRange& stretch : stretches) {
    std::size_t begin = stretch.begin;
    for (std::size_t i = stretch.begin + 1; i < stretch.end; ++i) {
      if (!HasGap(samples.subspan(i - 1, 2), step)) continue;
      parts.push_back({begin, i});
      begin = i;
    }
    parts.push_back({begin, stretch.end});
  }
  return parts;
}

struct Window {
  ReadingRange range;
  Variances variances;
};

// Returns the consecutive windows that could be at rest: those that are IsStationary() and have no
// gap.
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

// Returns the lowest decile of the variances of the windows.
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

// Empty if a curve has too few points.
std::optional<SensorNoise> EstimateNoiseOf(std::span<const ImuSample> samples,
                                           std::span<const ReadingRange> rest, double step,
                                           Eigen::Vector3d ImuSample::*part,
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
    const std::vector<AllanPoint> curve = AllanDeviation(stretches, step);
    // A coarsely quantized axis repeats one value: its noise is not observable.
    const auto moves = [](const AllanPoint& point) { return point.deviation > 0.0; };
    if (std::ranges::all_of(curve, moves)) {
      const std::optional<NoiseDensities> fitted = FitAllanCurve(curve, fit);
      if (!fitted) return std::nullopt;
      noise.axes[static_cast<std::size_t>(axis)] = *fitted;
    }
    std::ranges::move(stretches, std::back_inserter(all));
  }
  noise.curve = AllanDeviation(all, step);
  const std::optional<NoiseDensities> fitted = FitAllanCurve(noise.curve, fit);
  if (!fitted) return std::nullopt;
  noise.all = *fitted;
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
  const double step = StepOf(samples);
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

std::optional<ImuNoiseEstimate> EstimateImuNoise(std::span<const ImuSample> samples,
                                                 std::span<const ReadingRange> rest,
                                                 const ImuNoiseEstimationOptions& options) {
  options.Validate();
  for (const ReadingRange& range : rest) {
    HIGHWALL_REQUIRE(range.begin <= range.end && range.end <= samples.size(),
                     "a stretch of rest lies outside of the readings");
  }
  if (samples.size() < 2) return std::nullopt;
  const double step = StepOf(samples);
  const std::vector<ReadingRange> parts = SplitAtGaps(samples, rest, step);
  std::size_t longest = 0;
  for (const ReadingRange& part : parts) longest = std::max(longest, part.end - part.begin);
  // Three octaves are needed, the longest a third of the stretch.
  const auto needed = static_cast<std::size_t>(12 * options.min_readings);
  if (longest < needed) return std::nullopt;
  const auto gyroscope = EstimateNoiseOf(samples, parts, step, &ImuSample::gyroscope, options);
  const auto accelerometer =
      EstimateNoiseOf(samples, parts, step, &ImuSample::accelerometer, options);
  if (!gyroscope || !accelerometer) return std::nullopt;
  return ImuNoiseEstimate{.step = step, .gyroscope = *gyroscope, .accelerometer = *accelerometer};
}

}  // namespace highwall
