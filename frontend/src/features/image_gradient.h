#pragma once

#include <algorithm>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace highwall::internal {

// Sobel gradient of a slightly blurred image, with lookups that are valid everywhere: outside of
// the image, the gradient of the nearest pixel is returned.
class ImageGradient {
 public:
  static constexpr int kUnit = 128;  // of a gradient of one grey level per pixel

  ImageGradient() = default;
  // gray: CV_8UC1.
  explicit ImageGradient(const cv::Mat& gray) { Compute(gray); }

  // Replaces the image by one more, in the same memory if it is of the same size.
  void Compute(const cv::Mat& gray);

  // Returns the gradient at the nearest pixel, [1 / kUnit grey levels per px].
  Eigen::Vector2f Nearest(float x, float y) const {
    return At(static_cast<int>(x + 0.5F), static_cast<int>(y + 0.5F));
  }
  // Returns the gradients of row v in the image, d/dx and d/dy of each pixel in turn.
  const std::int16_t* Row(int v) const { return gradient_.ptr<std::int16_t>(v); }
  int width() const { return gradient_.cols; }
  int height() const { return gradient_.rows; }
  // Returns whether a point is in the image, and a pixel or more from its border.
  bool IsInside(const Eigen::Vector2f& p) const {
    return p.x() >= 1.0F && p.y() >= 1.0F && p.x() <= static_cast<float>(gradient_.cols - 2) &&
           p.y() <= static_cast<float>(gradient_.rows - 2);
  }

  // Returns the gradient of a pixel.
  Eigen::Vector2f At(int x, int y) const {
    const std::int16_t* g = gradient_.ptr<std::int16_t>(std::clamp(y, 0, gradient_.rows - 1)) +
                            2 * std::clamp(x, 0, gradient_.cols - 1);
    return {static_cast<float>(g[0]), static_cast<float>(g[1])};
  }

 private:
  cv::Mat gradient_;  // CV_16SC2: d/dx, d/dy
};

}  // namespace highwall::internal
