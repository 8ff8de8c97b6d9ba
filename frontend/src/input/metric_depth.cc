#include <cmath>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

// Metres from metres whose inverse is too large by `offset` [1/m].
float Mended(float z, double offset) {
  const double rest = 1.0 - offset * static_cast<double>(z);
  return rest > 0.0 ? static_cast<float>(static_cast<double>(z) / rest) : 0.0F;
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
    depth.forEach<float>([&](float& z, const int* at) {
      const double here = pattern.At(at[1], at[0], stored.cols, stored.rows);
      z = Mended(z, inverse_depth_offset + here);
    });
  } else if (inverse_depth_offset != 0.0) {
    depth.forEach<float>(
        [inverse_depth_offset](float& z, const int*) { z = Mended(z, inverse_depth_offset); });
  }
  return depth;
}

}  // namespace highwall
