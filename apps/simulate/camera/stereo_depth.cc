#include "simulate/camera/stereo_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <highwall/core/error.h>

#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

constexpr int kBlock = 8;          // [px] for measuring the contrast
constexpr float kFlat = 2.5f;      // [grey levels] contrast below which matches begin to fail
constexpr float kFlatLoss = 0.7f;  // share of matches that fail without contrast
constexpr float kStereoGrazingSure = 0.05f,
                kStereoGrazingPossible = 0.13f;  // cosines: no depth, full depth
constexpr int kGrain = 4;                        // [px] spacing of the correlated noise
constexpr float kShared = 0.8f;                  // its share of the variance

// Standard deviation of the grey levels within each block, row by row.
cv::Mat BlockContrast(const cv::Mat& bgr) {
  cv::Mat contrast((bgr.rows + kBlock - 1) / kBlock, (bgr.cols + kBlock - 1) / kBlock, CV_32FC1);
  for (int j = 0; j < contrast.rows; ++j) {
    for (int i = 0; i < contrast.cols; ++i) {
      float sum = 0.0f, squares = 0.0f, count = 0.0f;
      for (int v = j * kBlock; v < std::min(bgr.rows, (j + 1) * kBlock); ++v) {
        const auto* row = bgr.ptr<cv::Vec3f>(v);
        for (int u = i * kBlock; u < std::min(bgr.cols, (i + 1) * kBlock); ++u) {
          const float grey = row[u][1];  // green is a good approximation
          sum += grey;
          squares += grey * grey;
          count += 1.0f;
        }
      }
      const float mean = sum / count;
      contrast.at<float>(j, i) = std::sqrt(std::max(0.0f, squares / count - mean * mean));
    }
  }
  return contrast;
}

// Pixels of a row that the second camera does not see: a point to their right occludes them.
std::vector<bool> HiddenInRow(const float* depth, int width, float disparity_scale) {
  std::vector<bool> hidden(static_cast<std::size_t>(width));
  float leftmost = std::numeric_limits<float>::infinity();
  for (int u = width - 1; u >= 0; --u) {
    if (depth[u] == 0.0f) continue;
    const float there = static_cast<float>(u) - disparity_scale / depth[u];
    hidden[static_cast<std::size_t>(u)] = there > leftmost;
    leftmost = std::min(leftmost, there);
  }
  return hidden;
}

}  // namespace

void StereoOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(subpixel) && subpixel > 0.0,
                   "StereoOptions::subpixel must be positive");
  HIGHWALL_REQUIRE(std::isfinite(focal) && focal > 0.0, "StereoOptions::focal must be positive");
  HIGHWALL_REQUIRE(std::isfinite(baseline) && baseline > 0.0,
                   "StereoOptions::baseline must be positive");
}

StereoDepth::StereoDepth(const StereoOptions& options, double noise_ratio,
                         const PinholeCamera& camera)
    : quadratic_((options.Validate(), noise_ratio * options.Noise().quadratic)),
      disparity_scale_(camera.fx * options.baseline) {}

cv::Mat StereoDepth::Measure(const Rendering& rendering, const CounterRandom& random,
                             int threads) const {
  const int w = rendering.depth.cols, h = rendering.depth.rows;
  const cv::Mat contrast = BlockContrast(rendering.bgr);
  const auto slope = static_cast<float>(quadratic_);
  const CounterRandom shared = random.Stream(1), own = random.Stream(2);
  const int columns = w / kGrain + 2;
  const auto shared_at = [&](int i, int j) {
    return normals_(shared.Bits(static_cast<std::uint64_t>(j * columns + i)), 0);
  };

  cv::Mat out(h, w, CV_32FC1);
  ParallelFor(h, threads, [&](int v) {
    const auto* ideal = rendering.depth.ptr<float>(v);
    const auto* cosine = rendering.cosine.ptr<float>(v);
    const std::vector<bool> hidden = HiddenInRow(ideal, w, static_cast<float>(disparity_scale_));
    std::vector<float> low, high;  // correlated noise above and below this row
    for (int i = 0; i < columns; ++i) {
      low.push_back(shared_at(i, v / kGrain));
      high.push_back(shared_at(i, v / kGrain + 1));
    }
    for (int u = 0; u < w; ++u) {
      const std::uint64_t bits = own.Bits(static_cast<std::uint64_t>(v * w + u));
      const float uniform = static_cast<float>(bits & 0xffff) * 0x1p-16f;
      const float flat = std::max(0.0f, 1.0f - contrast.at<float>(v / kBlock, u / kBlock) / kFlat);
      const bool lost =
          ideal[u] == 0.0f || hidden[static_cast<std::size_t>(u)] || uniform < kFlatLoss * flat ||
          uniform * (kStereoGrazingPossible - kStereoGrazingSure) > cosine[u] - kStereoGrazingSure;
      if (lost) {
        out.at<float>(v, u) = 0.0f;
        continue;
      }
      // Bilinear interpolation of the four surrounding numbers, normalized to unit variance.
      const float a = static_cast<float>(u % kGrain) / kGrain;
      const float b = static_cast<float>(v % kGrain) / kGrain;
      const auto i = static_cast<std::size_t>(u / kGrain);
      const float mixed =
          (1 - b) * ((1 - a) * low[i] + a * low[i + 1]) + b * ((1 - a) * high[i] + a * high[i + 1]);
      const float variance = ((1 - a) * (1 - a) + a * a) * ((1 - b) * (1 - b) + b * b);
      const float normal =
          std::sqrt(kShared / variance) * mixed + std::sqrt(1.0f - kShared) * normals_(bits, 16);
      out.at<float>(v, u) = ideal[u] + slope * ideal[u] * ideal[u] * normal;
    }
  });
  return out;
}

}  // namespace highwall::simulate
