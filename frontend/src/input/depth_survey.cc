#include <highwall/frontend/input/depth_survey.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <highwall/core/error.h>

#include "input/depth_steps.h"

namespace highwall {
namespace {

constexpr std::size_t kValues = std::numeric_limits<std::uint16_t>::max() + std::size_t{1};
constexpr double kEdge = 0.05;  // of the width and of the height
// minimum ratio of the depths on both sides of a gap at an occlusion edge
constexpr double kFar = 1.1;

constexpr int kRadius = 3;                 // [px] of a patch
constexpr double kMaxSlope = 0.15;         // of the depth, across a patch: a larger one is an edge
constexpr std::size_t kMinPatches = 50;    // in a third octave
constexpr std::size_t kMaxPatches = 4000;  // per image and third octave

int ThirdOctave(double value) {
  return static_cast<int>(std::floor(3.0 * std::log2(value)));
}

// Standard deviation [1/stored unit] of the inverse depths of a patch from their plane; empty if a
// reading is missing or the surface ends. Inverse depth is affine over the image of a plane.
std::optional<double> Residual(const cv::Mat& raw, int u, int v) {
  constexpr int kSide = 2 * kRadius + 1;
  std::array<double, kSide * kSide> inverse{};
  const double centre = raw.at<std::uint16_t>(v, u);
  double mean = 0.0, slope_u = 0.0, slope_v = 0.0, squared = 0.0;
  std::size_t i = 0;
  for (int dv = -kRadius; dv <= kRadius; ++dv) {
    for (int du = -kRadius; du <= kRadius; ++du, ++i) {
      const double value = raw.at<std::uint16_t>(v + dv, u + du);
      if (value == 0.0 || std::abs(value - centre) > kMaxSlope * centre) return std::nullopt;
      inverse[i] = 1.0 / value;
      mean += inverse[i];
      slope_u += du * inverse[i];
      slope_v += dv * inverse[i];
      squared += du * du;
    }
  }
  constexpr double kCount = kSide * kSide;
  mean /= kCount;
  slope_u /= squared;
  slope_v /= squared;
  double sum = 0.0;
  i = 0;
  for (int dv = -kRadius; dv <= kRadius; ++dv) {
    for (int du = -kRadius; du <= kRadius; ++du, ++i) {
      const double off = inverse[i] - mean - slope_u * du - slope_v * dv;
      sum += off * off;
    }
  }
  return std::sqrt(sum / (kCount - 3.0));
}

// values: at least one; share in [0, 1].
template <typename T>
T Quantile(std::vector<T> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Returns the smallest value that `share` of the readings do not exceed.
double Quantile(DepthHistogram histogram, std::uint64_t readings, double share) {
  std::uint64_t below = 0;
  for (std::size_t value = 1; value < histogram.size(); ++value) {
    below += histogram[value];
    if (static_cast<double>(below) >= share * static_cast<double>(readings)) {
      return static_cast<double>(value);
    }
  }
  return 0.0;
}

double Share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void DepthSurvey::Add(const cv::Mat& raw) {
  HIGHWALL_REQUIRE(raw.type() == CV_16UC1 && !raw.empty(),
                   "DepthSurvey: the image must be CV_16UC1");
  HIGHWALL_REQUIRE(histogram_.empty() || (raw.cols == width_ && raw.rows == height_),
                   "DepthSurvey: the images differ in size");
  histogram_.resize(kValues);
  width_ = raw.cols;
  height_ = raw.rows;
  for (int v = 0; v < raw.rows; ++v) {
    const auto* row = raw.ptr<std::uint16_t>(v);
    for (int u = 0; u < raw.cols; ++u) ++histogram_[row[u]];
  }
  AddHoles(raw);
  AddGrain(raw);
}

void DepthSurvey::AddHoles(const cv::Mat& raw) {
  const int edge_u = static_cast<int>(std::lround(kEdge * raw.cols));
  const int edge_v = static_cast<int>(std::lround(kEdge * raw.rows));
  const int longest = raw.cols / 10;  // [px] maximum length of a gap at an edge
  for (int v = 0; v < raw.rows; ++v) {
    const auto* row = raw.ptr<std::uint16_t>(v);
    const bool at_v = v < edge_v || v >= raw.rows - edge_v;
    int last = -1;  // column of the last reading
    for (int u = 0; u < raw.cols; ++u) {
      const bool hole = row[u] == 0, at_u = u < edge_u || u >= raw.cols - edge_u;
      if (at_u || at_v) {
        ++edge_;
        edge_holes_ += hole ? 1 : 0;
      }
      if (at_u && at_v) {
        ++corner_;
        corner_holes_ += hole ? 1 : 0;
      }
      if (hole) continue;
      if (last >= 0 && u - last > 2 && u - last <= longest) {
        if (row[u] * kFar < row[last]) ++left_gaps_;
        if (row[last] * kFar < row[u]) ++right_gaps_;
      }
      last = u;
    }
  }
}

void DepthSurvey::AddGrain(const cv::Mat& raw) {
  std::map<int, std::size_t> taken;
  for (int v = kRadius; v < raw.rows - kRadius; v += 2 * kRadius + 1) {
    for (int u = kRadius; u < raw.cols - kRadius; u += 2 * kRadius + 1) {
      const double value = raw.at<std::uint16_t>(v, u);
      if (value == 0.0) continue;
      const int octave = ThirdOctave(value);
      if (taken[octave] >= kMaxPatches) continue;
      const std::optional<double> residual = Residual(raw, u, v);
      if (!residual) continue;
      ++taken[octave];
      residuals_[octave].push_back(static_cast<float>(*residual * value * value));
    }
  }
}

DepthStatistics DepthSurvey::Describe() const {
  HIGHWALL_REQUIRE(!histogram_.empty(), "DepthSurvey: no image was added");
  DepthStatistics statistics{.width = width_, .height = height_};
  std::uint64_t pixels = 0;
  for (const std::uint64_t count : histogram_) pixels += count;
  const std::uint64_t readings = pixels - histogram_[0];
  statistics.readings = readings;
  statistics.holes = Share(histogram_[0], pixels);
  statistics.edge_holes = Share(edge_holes_, edge_);
  statistics.corner_holes = Share(corner_holes_, corner_);
  statistics.gaps = left_gaps_ + right_gaps_;
  statistics.left_holes = Share(left_gaps_, left_gaps_ + right_gaps_);
  if (readings == 0) return statistics;
  statistics.nearest = Quantile(histogram_, readings, 0.001);
  statistics.farthest = Quantile(histogram_, readings, 0.999);
  constexpr std::array<double, 5> kShares{0.05, 0.25, 0.5, 0.75, 0.95};
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    statistics.quantiles[i] = Quantile(histogram_, readings, kShares[i]);
  }
  if (const auto unit = FindUnit(histogram_)) statistics.unit = unit->spacing;
  if (const auto steps = FindInverseSteps(histogram_)) {
    statistics.inverse_step = steps->spacing;
    statistics.inverse_step_coherence = steps->coherence;
  }
  for (const auto& [octave, residuals] : residuals_) {
    if (residuals.size() < kMinPatches) continue;
    statistics.grain.push_back({std::exp2((octave + 0.5) / 3.0),
                                static_cast<double>(Quantile(residuals, 0.25)), residuals.size()});
  }
  return statistics;
}

}  // namespace highwall
