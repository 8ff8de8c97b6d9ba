#include "input/depth_unit.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <highwall/core/error.h>

namespace highwall {

bool IsMetric(const cv::Mat& depth) {
  constexpr float kFarthest = 100.0F;  // [m] of any depth camera
  std::vector<float> readings;
  for (int v = 0; v < depth.rows; ++v) {
    const auto* const row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (!std::isfinite(row[u]) || row[u] <= 0.0F) continue;
      if (row[u] <= kFarthest) return true;
      readings.push_back(row[u]);
    }
  }
  if (100 * readings.size() < depth.total() || readings.empty()) return false;
  const auto median = readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2);
  std::nth_element(readings.begin(), median, readings.end());
  throw InvalidArgument("depth must be in metres, but all of it lies beyond 100 m (median " +
                        std::to_string(std::lround(*median)) +
                        " m): divide it by the depth factor of the sensor (depth_factor in "
                        "calibration.yaml)");
}

}  // namespace highwall
