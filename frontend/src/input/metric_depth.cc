#include <cmath>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/require.h>

namespace highwall {

cv::Mat MetricDepth(const cv::Mat& stored, double depth_factor, double inverse_depth_offset) {
  HIGHWALL_REQUIRE(stored.type() == CV_16UC1 || stored.type() == CV_32FC1,
                   "MetricDepth: the image must be CV_16UC1 or CV_32FC1");
  RequirePositiveFinite(depth_factor, "MetricDepth: depth_factor");
  HIGHWALL_REQUIRE(std::isfinite(inverse_depth_offset),
                   "MetricDepth: inverse_depth_offset must be finite");
  cv::Mat depth;
  stored.convertTo(depth, CV_32F, 1.0 / depth_factor);
  if (inverse_depth_offset == 0.0) return depth;
  depth.forEach<float>([inverse_depth_offset](float& z, const int*) {
    const double rest = 1.0 - inverse_depth_offset * static_cast<double>(z);
    z = rest > 0.0 ? static_cast<float>(static_cast<double>(z) / rest) : 0.0F;
  });
  return depth;
}

}  // namespace highwall
