#include "features/image_gradient.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace highwall::internal {

ImageGradient::ImageGradient(const cv::Mat& gray) {
  cv::Mat blurred, dx, dy;
  cv::GaussianBlur(gray, blurred, cv::Size(5, 5), 1.0);
  cv::spatialGradient(blurred, dx, dy, 3, cv::BORDER_REPLICATE);
  cv::merge(std::vector<cv::Mat>{dx, dy}, gradient_);
}

Eigen::Vector2f ImageGradient::At(const Eigen::Vector2f& p) const {
  if (IsInside(p)) {  // needs neither floor() nor clamping
    const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
    const float ax = p.x() - static_cast<float>(x), ay = p.y() - static_cast<float>(y);
    const std::int16_t *g = Row(y) + 2 * x, *h = Row(y + 1) + 2 * x;
    const auto blended = [&](int k) {
      return (1.0F - ay) *
                 ((1.0F - ax) * static_cast<float>(g[k]) + ax * static_cast<float>(g[k + 2])) +
             ay * ((1.0F - ax) * static_cast<float>(h[k]) + ax * static_cast<float>(h[k + 2]));
    };
    return {blended(0), blended(1)};
  }
  const float fx = std::floor(p.x()), fy = std::floor(p.y());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy);
  const float ax = p.x() - fx, ay = p.y() - fy;
  return (1.0F - ay) * ((1.0F - ax) * At(x, y) + ax * At(x + 1, y)) +
         ay * ((1.0F - ax) * At(x, y + 1) + ax * At(x + 1, y + 1));
}

}  // namespace highwall::internal
