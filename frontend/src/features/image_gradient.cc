#include "features/image_gradient.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace highwall::internal {

ImageGradient::ImageGradient(const cv::Mat& gray) {
  cv::Mat blurred, dx, dy;
  cv::GaussianBlur(gray, blurred, cv::Size(5, 5), 1.0);
  cv::spatialGradient(blurred, dx, dy, 3, cv::BORDER_REPLICATE);
  cv::merge(std::vector<cv::Mat>{dx, dy}, gradient_);
}

Eigen::Vector2f ImageGradient::At(const Eigen::Vector2f& p) const {
  const float fx = std::floor(p.x()), fy = std::floor(p.y());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy);
  const float ax = p.x() - fx, ay = p.y() - fy;
  return (1.0F - ay) * ((1.0F - ax) * At(x, y) + ax * At(x + 1, y)) +
         ay * ((1.0F - ax) * At(x, y + 1) + ax * At(x + 1, y + 1));
}

}  // namespace highwall::internal
