#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "features/image_noise.h"

namespace highwall::internal::image_noise_test {
namespace {

// Returns grey levels of a slope, optionally with boxes on it, and with noise.
cv::Mat Image(double sigma, bool boxes, std::uint64_t seed) {
  cv::Mat image(240, 320, CV_32F);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<float>(v, u) = 60.0F + 0.25F * static_cast<float>(u + v);
    }
  }
  cv::RNG rng(seed);
  if (boxes) {
    for (int i = 0; i < 60; ++i) {
      const cv::Rect box(rng.uniform(0, 300), rng.uniform(0, 220), 14, 14);
      cv::rectangle(image, box, cv::Scalar::all(rng.uniform(40, 200)), cv::FILLED);
    }
  }
  cv::Mat noise(image.size(), CV_32F), gray;
  rng.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat(image + noise).convertTo(gray, CV_8U);
  return gray;
}

// The median of the 4,700 residuals is a whole number: the estimate is within half of 1 / 4.05 of a
// grey level, and the rounding of the image adds a variance of 1/12.
TEST(NoiseSigma, IsThatOfTheNoise) {
  for (const double sigma : {1.0, 2.0, 5.0}) {
    EXPECT_NEAR(NoiseSigma(Image(sigma, false, 1)), std::sqrt(sigma * sigma + 1.0 / 12.0), 0.25)
        << sigma;
  }
}

TEST(NoiseSigma, CountsEdgesLittle) {
  EXPECT_NEAR(NoiseSigma(Image(2.0, true, 2)), NoiseSigma(Image(2.0, false, 2)), 0.5);
}

TEST(NoiseSigma, IsThatOfTheOtherPixelsWhereHalfIsBlackOrWhite) {
  for (const double level : {0.0, 255.0}) {
    cv::Mat image = Image(2.0, false, 3);
    image.colRange(0, 200).setTo(level);
    EXPECT_NEAR(NoiseSigma(image), NoiseSigma(Image(2.0, false, 3)), 0.25) << level;
  }
}

TEST(NoiseSigma, IsNoneOfFlatAndOfTinyImages) {
  EXPECT_EQ(NoiseSigma(cv::Mat(48, 64, CV_8U, cv::Scalar(7))), 0.0);
  EXPECT_EQ(NoiseSigma(cv::Mat(2, 2, CV_8U, cv::Scalar(7))), 0.0);
}

}  // namespace
}  // namespace highwall::internal::image_noise_test
