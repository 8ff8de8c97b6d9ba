#include "input/depth_unit.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <highwall/core/error.h>

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

}  // namespace highwall
