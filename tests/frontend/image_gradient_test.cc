#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "features/image_gradient.h"

namespace highwall::image_gradient_test {
namespace {

cv::Mat Noise(int rows, int cols, double sigma, std::uint64_t seed) {
  cv::Mat noise(rows, cols, CV_32F), image;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 128.0, sigma);
  noise.convertTo(image, CV_8U);
  return image;
}

// Against sums over the image in whole numbers; the nearest pixel stands for those outside.
TEST(ImageGradient, IsTheSobelDerivativeOfTheBlurredImage) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(1, 9), cv::Size(9, 1), cv::Size(2, 3), cv::Size(37, 22)}) {
    // Most pixels are black or white, and gradients as large as they get.
    const cv::Mat image = Noise(size.height, size.width, 1000.0, 4);
    const internal::ImageGradient gradient(image);
    const auto blurred = [&](int x, int y) {
      constexpr int kWeights[] = {1, 4, 6, 4, 1};
      x = std::clamp(x, 0, size.width - 1);
      y = std::clamp(y, 0, size.height - 1);
      int sum = 8;
      for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 5; ++j) {
          sum += kWeights[i] * kWeights[j] *
                 image.at<std::uint8_t>(std::clamp(y + i - 2, 0, size.height - 1),
                                        std::clamp(x + j - 2, 0, size.width - 1));
        }
      }
      return sum / 16;
    };
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        int dx = 0, dy = 0;
        for (int i = -1; i <= 1; ++i) {
          dx += (i == 0 ? 2 : 1) * (blurred(x + 1, y + i) - blurred(x - 1, y + i));
          dy += (i == 0 ? 2 : 1) * (blurred(x + i, y + 1) - blurred(x + i, y - 1));
        }
        EXPECT_EQ(gradient.At(x, y), Eigen::Vector2f(Eigen::Vector2i(dx, dy).cast<float>()))
            << size << " " << x << " " << y;
      }
    }
  }
}

// The memory of another image is used, and rows of a part of an image do not follow one another.
TEST(ImageGradient, DependsOnNothingButTheImage) {
  const cv::Mat image = Noise(40, 60, 60.0, 5);
  internal::ImageGradient used(Noise(70, 30, 60.0, 6));
  for (const cv::Mat& part : {image(cv::Rect(7, 3, 31, 22)), image(cv::Rect(20, 9, 31, 22))}) {
    used.Compute(part);
    const internal::ImageGradient expected(part.clone());
    ASSERT_EQ(used.width(), 31);
    ASSERT_EQ(used.height(), 22);
    for (int y = 0; y < 22; ++y) {
      EXPECT_TRUE(std::equal(used.Row(y), used.Row(y) + 62, expected.Row(y))) << y;
    }
  }
}

// The unit of the gradient: a ramp of three grey levels per pixel.
TEST(ImageGradient, HasTheUnitThatItStates) {
  cv::Mat ramp(20, 30, CV_8U);
  for (int v = 0; v < ramp.rows; ++v) {
    for (int u = 0; u < ramp.cols; ++u) {
      ramp.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(3 * u + v);
    }
  }
  EXPECT_EQ(internal::ImageGradient(ramp).At(15, 10),
            Eigen::Vector2f(3.0F * internal::ImageGradient::kUnit, internal::ImageGradient::kUnit));
}

}  // namespace
}  // namespace highwall::image_gradient_test
