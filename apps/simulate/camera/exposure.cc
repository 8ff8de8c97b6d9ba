#include "simulate/camera/exposure.h"

#include <algorithm>
#include <cmath>

#include <highwall/core/error.h>

namespace highwall::simulate {
namespace {

constexpr double kShortest = 1e-4;  // [s]

// Averages every eighth pixel in every eighth row over all three channels.
double Mean(const cv::Mat& bgr) {
  constexpr int kStep = 8;
  double sum = 0.0;
  int count = 0;
  for (int v = 0; v < bgr.rows; v += kStep) {
    for (int u = 0; u < bgr.cols; u += kStep, ++count) {
      const auto& pixel = bgr.at<cv::Vec3f>(v, u);
      for (int k = 0; k < 3; ++k) sum += static_cast<double>(pixel[k]) / 3.0;
    }
  }
  return sum / count;
}

}  // namespace

void ExposureOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(time) && time > 0.0, "ExposureOptions::time must be positive");
  HIGHWALL_REQUIRE(std::isfinite(max_time) && max_time >= time,
                   "ExposureOptions::max_time must not be less than time");
  HIGHWALL_REQUIRE(std::isfinite(max_gain) && max_gain >= 1.0,
                   "ExposureOptions::max_gain must be at least 1");
  HIGHWALL_REQUIRE(target > 0.0 && target < 255.0,
                   "ExposureOptions::target must lie between 0 and 255");
  HIGHWALL_REQUIRE(vignetting >= 0.0 && vignetting < 1.0,
                   "ExposureOptions::vignetting must lie in [0, 1)");
}

Exposure ChooseExposure(const ExposureOptions& options, const cv::Mat& bgr) {
  switch (options.mode) {
    case ExposureMode::kIdeal:
      return {};
    case ExposureMode::kFixed:
      return {.time = options.time, .gain = 1.0, .scale = 1.0};
    case ExposureMode::kAuto:
      break;
  }
  const double need = options.target / std::max(Mean(bgr), 1e-3);
  const double time = std::clamp(options.time * need, kShortest, options.max_time);
  const double gain = std::clamp(need * options.time / time, 1.0, options.max_gain);
  return {.time = time, .gain = gain, .scale = time / options.time * gain};
}

void Expose(const ExposureOptions& options, const Exposure& exposure, cv::Mat* bgr) {
  if (options.mode == ExposureMode::kIdeal) return;
  const float half_width = 0.5f * static_cast<float>(bgr->cols - 1);
  const float half_height = 0.5f * static_cast<float>(bgr->rows - 1);
  const float corner = half_width * half_width + half_height * half_height;
  const auto scale = static_cast<float>(exposure.scale);
  const auto loss = static_cast<float>(exposure.scale * options.vignetting) / corner;
  for (int v = 0; v < bgr->rows; ++v) {
    auto* row = bgr->ptr<cv::Vec3f>(v);
    const float y = static_cast<float>(v) - half_height;
    for (int u = 0; u < bgr->cols; ++u) {
      const float x = static_cast<float>(u) - half_width;
      row[u] *= scale - loss * (x * x + y * y);
    }
  }
}

}  // namespace highwall::simulate
