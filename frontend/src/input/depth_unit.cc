#include "input/depth_unit.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

namespace highwall {

bool IsMetric(const cv::Mat& depth) {
  constexpr float kFarthest = 100.0F;     // [m] maximum range of any depth camera
  constexpr std::size_t kFewest = 100;    // one pixel in so many has a reading
  constexpr std::size_t kNearShare = 10;  // one reading in so many lies within
  std::vector<float> readings;
  std::size_t near = 0;
  for (int v = 0; v < depth.rows; ++v) {
    const auto* const row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (!std::isfinite(row[u]) || row[u] <= 0.0F) continue;
      if (row[u] <= kFarthest) ++near;
      readings.push_back(row[u]);
    }
  }
  if (readings.empty() || kFewest * readings.size() < depth.total()) return false;
  if (kNearShare * near >= readings.size()) return true;
  const auto median = readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2);
  std::nth_element(readings.begin(), median, readings.end());
  const std::size_t beyond = 100 * (readings.size() - near) / readings.size();
  throw InvalidArgument("depth must be in metres, but " +
                        (near == 0 ? std::string("all") : std::to_string(beyond) + " %") +
                        " of it lies beyond 100 m (median " + std::to_string(std::lround(*median)) +
                        " m): divide it by the depth factor of the sensor (depth_factor in "
                        "calibration.yaml)");
}

std::optional<std::string> DoubtOfDepthFactor(std::size_t images, double depth_factor,
                                              const std::function<cv::Mat(std::size_t)>& read) {
  constexpr std::size_t kImages = 5;
  constexpr int kStep = 8;
  std::vector<float> depths;
  const std::size_t stride = std::max<std::size_t>(1, images / kImages);
  for (std::size_t i = 0; i < images; i += stride) {
    try {
      const cv::Mat depth = read(i);
      for (int v = 0; v < depth.rows; v += kStep) {
        for (int u = 0; u < depth.cols; u += kStep) {
          if (depth.at<float>(v, u) > 0.0F) depths.push_back(depth.at<float>(v, u));
        }
      }
    } catch (const IoError&) {  // Load() reports it
    }
  }
  if (depths.empty()) return std::nullopt;
  const double median = UpperMedian(std::move(depths));
  const std::optional<double> factor = LikelyDepthFactor(median, depth_factor);
  if (!factor) return std::nullopt;
  return "the median depth is " + RoundedText(median, 4) + " m with depth factor " +
         RoundedText(depth_factor, 4) +
         (*factor > 0.0 ? "; the factor is likely " + RoundedText(*factor, 4)
                        : "; no usual factor makes it plausible");
}

}  // namespace highwall
