#include "input/depth_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

constexpr std::size_t kAllValues = std::numeric_limits<std::uint16_t>::max() + std::size_t{1};
constexpr std::size_t kFewestImages = 4;
constexpr double kUniform = 0.98;  // of the readings: even a wall shows the noise of its depth
// [grey levels] mean difference of colour images that show different views
constexpr double kOtherView = 4.0;
// Mean relative step from a reading to the next, edges included. The smoothest depth (filtered by
// its driver) has 0.007 with its bytes exchanged, and 0.0005 without.
constexpr double kWild = 0.004;
constexpr double kSmoother = 4.0;         // ratio of such steps
constexpr double kLeastSentinels = 0.01;  // share of the pixels
// of the sentinels: the readings in the upper half of the values below them
constexpr double kMostBetween = 0.02;

// Readings next to those of the commonest value, at least, and the share of them within 5 % of it.
// A surface continues beside its commonest reading; what stands for no reading ends anywhere.
constexpr int kFewestBeside = 20;
constexpr double kBeside = 0.05, kMostBeside = 0.3;

std::uint16_t Swapped(std::uint16_t value) {
  return static_cast<std::uint16_t>((value << 8) | (value >> 8));
}

double RelativeStep(double a, double b) {
  return std::abs(a - b) / std::max(a, b);
}

// Whether most readings next to those of this value are far from it: by more than 5 %, and beyond
// the next value of the image, which may have coarse steps.
bool StandsOut(const cv::Mat& raw, std::size_t value, const std::vector<std::uint64_t>& histogram,
               int step) {
  std::size_t lower = value - 1, upper = value + 1;
  while (lower > 0 && histogram[lower] == 0) --lower;
  while (upper + 1 < kAllValues && histogram[upper] == 0) ++upper;
  int beside = 0, near = 0;
  const auto add = [&](std::uint16_t other) {
    ++beside;
    near += RelativeStep(other, static_cast<double>(value)) < kBeside ||
                    (other >= lower && other <= upper)
                ? 1
                : 0;
  };
  for (int v = 0; v < raw.rows; v += step) {
    const auto* row = raw.ptr<std::uint16_t>(v);
    for (int u = 0; u + 1 < raw.cols; ++u) {
      if (row[u] == value && row[u + 1] != value && row[u + 1] != 0) add(row[u + 1]);
      if (row[u + 1] == value && row[u] != value && row[u] != 0) add(row[u]);
    }
  }
  return beside >= kFewestBeside && near < kMostBeside * beside;
}

// Whether this holds for all images but one in eight.
template <typename Holds>
bool HoldsForNearlyAll(std::size_t images, const Holds& holds) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < images; ++i) count += holds(i) ? 1 : 0;
  return images >= kFewestImages && 8 * (images - count) <= images;
}

}  // namespace

void DepthValues::Add(const cv::Mat& raw, const cv::Mat& bgr) {
  constexpr int kStep = 4;  // [px] between samples
  histogram_.resize(kAllValues);
  std::vector<std::uint64_t> histogram(kAllValues);
  double steps = 0.0, swapped = 0.0;
  std::uint64_t readings = 0, pairs = 0;
  for (int v = 0; v < raw.rows; v += kStep) {
    const auto* row = raw.ptr<std::uint16_t>(v);
    for (int u = 0; u + 1 < raw.cols; u += kStep) {
      ++histogram[row[u]];
      if (row[u] == 0) continue;
      ++readings;
      if (row[u + 1] == 0) continue;
      ++pairs;
      steps += RelativeStep(row[u], row[u + 1]);
      swapped += RelativeStep(Swapped(row[u]), Swapped(row[u + 1]));
    }
  }
  for (std::size_t value = 0; value < kAllValues; ++value) histogram_[value] += histogram[value];
  if (readings == 0) return;
  const auto commonest = std::max_element(histogram.begin() + 1, histogram.end());
  commonest_.push_back(static_cast<double>(*commonest) / static_cast<double>(readings));
  commonest_value_.push_back(static_cast<std::size_t>(commonest - histogram.begin()));
  stands_out_.push_back(StandsOut(raw, commonest_value_.back(), histogram, kStep));
  std::size_t highest = kAllValues - 1;
  while (histogram[highest] == 0) --highest;
  highest_.push_back(highest);
  const double count = std::max(1.0, static_cast<double>(pairs));
  steps_.push_back(steps / count);
  swapped_steps_.push_back(swapped / count);
  cv::Mat gray;
  cv::resize(bgr, gray, {}, 1.0 / kStep, 1.0 / kStep, cv::INTER_NEAREST);
  cv::cvtColor(gray, gray, cv::COLOR_BGR2GRAY);
  if (first_.empty()) {
    first_ = raw.clone();
    first_gray_ = gray;
    return;
  }
  if (raw.size() != first_.size()) return;
  repeated_ += cv::countNonZero(raw != first_) == 0 ? 1 : 0;
  changed_ +=
      cv::norm(gray, first_gray_, cv::NORM_L1) > kOtherView * static_cast<double>(gray.total()) ? 1
                                                                                                : 0;
}

bool DepthValues::IsUniform() const {
  return HoldsForNearlyAll(commonest_.size(),
                           [&](std::size_t i) { return commonest_[i] > kUniform; });
}

bool DepthValues::IsFrozen() const {
  const std::size_t images = commonest_.size();
  return images >= kFewestImages && repeated_ + 1 == images && 2 * changed_ >= images;
}

bool DepthValues::HasSwappedBytes() const {
  return HoldsForNearlyAll(steps_.size(), [&](std::size_t i) {
    return steps_[i] > kWild && kSmoother * swapped_steps_[i] < steps_[i];
  });
}

std::optional<SentinelValue> DepthValues::Sentinel() const {
  const std::optional<SentinelValue> highest = HighestSentinel();
  return highest ? highest : CommonestSentinel();
}

std::optional<SentinelValue> DepthValues::CommonestSentinel() const {
  if (commonest_value_.empty()) return std::nullopt;
  const auto commonest = std::max_element(histogram_.begin() + 1, histogram_.end());
  const auto value = static_cast<std::size_t>(commonest - histogram_.begin());
  std::uint64_t pixels = 0;
  for (const std::uint64_t count : histogram_) pixels += count;
  const double share = static_cast<double>(histogram_[value]) / static_cast<double>(pixels);
  const bool stands_out = HoldsForNearlyAll(stands_out_.size(), [&](std::size_t i) {
    return commonest_value_[i] == value && stands_out_[i];
  });
  if (share < kLeastSentinels || !stands_out) return std::nullopt;
  return SentinelValue{static_cast<int>(value), share};
}

std::optional<SentinelValue> DepthValues::HighestSentinel() const {
  if (highest_.empty()) return std::nullopt;
  const std::size_t value = *std::ranges::max_element(highest_);
  if (!HoldsForNearlyAll(highest_.size(), [&](std::size_t i) { return highest_[i] == value; })) {
    return std::nullopt;
  }
  std::uint64_t pixels = 0, between = 0;
  for (const std::uint64_t count : histogram_) pixels += count;
  // The end of the values may also be where farther readings were cut off.
  const std::size_t from = value + 1 == kAllValues ? value - value / 32 : value / 2;
  for (std::size_t below = from; below < value; ++below) between += histogram_[below];
  const auto count = static_cast<double>(histogram_[value]);
  const double share = count / static_cast<double>(pixels);
  if (share < kLeastSentinels || static_cast<double>(between) > kMostBetween * count) {
    return std::nullopt;
  }
  return SentinelValue{static_cast<int>(value), share};
}

}  // namespace highwall
