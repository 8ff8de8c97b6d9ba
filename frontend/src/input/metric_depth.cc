#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

// Corrects a depth [m] whose inverse is too large by `offset` [1/m].
float Corrected(float z, double offset) {
  const double rest = 1.0 - offset * static_cast<double>(z);
  return rest > 0.0 ? static_cast<float>(static_cast<double>(z) / rest) : 0.0F;
}

// Subtracts the offset and the pattern [1/m] from the inverse depths of a row: between the columns
// of nodes the pattern is linear.
void CorrectRow(int v, double offset, const DepthPattern& pattern, cv::Mat* depth) {
  std::array<double, DepthPattern::kColumns> at_nodes{};
  const double step = (depth->cols - 1) / (at_nodes.size() - 1.0);  // [px]
  for (std::size_t i = 0; i < at_nodes.size(); ++i) {
    at_nodes[i] = offset + pattern.At(static_cast<double>(i) * step, v, depth->cols, depth->rows);
  }
  auto* const row = depth->ptr<float>(v);
  for (int u = 0; u < depth->cols; ++u) {
    const double x = step > 0.0 ? u / step : 0.0;
    const std::size_t left = std::min(static_cast<std::size_t>(x), at_nodes.size() - 2);
    const double share = x - static_cast<double>(left);
    row[u] = Corrected(row[u], (1.0 - share) * at_nodes[left] + share * at_nodes[left + 1]);
  }
}

}  // namespace

cv::Mat MetricDepth(const cv::Mat& stored, double depth_factor, double inverse_depth_offset,
                    const DepthPattern& pattern) {
  HIGHWALL_REQUIRE(stored.type() == CV_16UC1 || stored.type() == CV_32FC1,
                   "MetricDepth: the image must be CV_16UC1 or CV_32FC1");
  RequirePositiveFinite(depth_factor, "MetricDepth: depth_factor");
  HIGHWALL_REQUIRE(std::isfinite(inverse_depth_offset),
                   "MetricDepth: inverse_depth_offset must be finite");
  pattern.Validate();
  cv::Mat depth;
  stored.convertTo(depth, CV_32F, 1.0 / depth_factor);
  if (!pattern.IsZero()) {
    for (int v = 0; v < depth.rows; ++v) CorrectRow(v, inverse_depth_offset, pattern, &depth);
  } else if (inverse_depth_offset != 0.0) {
    depth.forEach<float>(
        [inverse_depth_offset](float& z, const int*) { z = Corrected(z, inverse_depth_offset); });
  }
  return depth;
}

}  // namespace highwall
