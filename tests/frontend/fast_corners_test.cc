#include "features/fast_corners.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace highwall::fast_corners_test {
namespace {

constexpr int kMargin = 3;  // [px] that cv::FAST leaves out around its image

cv::Mat SmoothNoise(double sigma, std::uint64_t seed) {
  cv::Mat image(120, 160, CV_8UC1);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  if (sigma > 0.0) cv::GaussianBlur(image, image, cv::Size(0, 0), sigma);
  return image;
}

std::vector<cv::KeyPoint> OfOpenCv(const cv::Mat& image, const cv::Rect& area, int threshold) {
  const cv::Point margin(kMargin, kMargin);
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image(cv::Rect(area.tl() - margin, area.br() + margin)), corners, threshold, true);
  for (cv::KeyPoint& corner : corners) corner.pt += cv::Point2f(area.tl() - margin);
  return corners;
}

// Returns the number of corners.
std::size_t ExpectThoseOfOpenCv(const cv::Mat& image, const cv::Rect& area, int threshold) {
  std::vector<cv::KeyPoint> corners;
  internal::FastCorners().Append(image, area, threshold, &corners);
  const std::vector<cv::KeyPoint> expected = OfOpenCv(image, area, threshold);
  EXPECT_EQ(corners.size(), expected.size()) << area << " at " << threshold;
  for (std::size_t i = 0; i < std::min(corners.size(), expected.size()); ++i) {
    EXPECT_EQ(corners[i].pt, expected[i].pt);
    EXPECT_EQ(corners[i].response, expected[i].response);
    EXPECT_EQ(corners[i].size, expected[i].size);
    EXPECT_EQ(corners[i].angle, expected[i].angle);
  }
  return corners.size();
}

TEST(FastCorners, AreThoseOfOpenCvWithinAnyArea) {
  // Widths below, at and beyond the 32 pixels that are scored together.
  const std::vector<cv::Rect> areas{{3, 3, 154, 114}, {20, 30, 32, 32}, {40, 17, 16, 8},
                                    {50, 60, 7, 20},  {3, 113, 49, 4},  {20, 30, 31, 9},
                                    {21, 31, 33, 9},  {156, 3, 1, 114}};
  std::size_t found = 0;
  for (const double sigma : {0.0, 0.8, 2.0}) {
    for (const int threshold : {0, 2, 7, 20, 254, 255}) {
      const cv::Mat image = SmoothNoise(sigma, 5);
      // A part of an image, whose rows are farther apart than it is wide.
      found += ExpectThoseOfOpenCv(image(cv::Rect(5, 5, 100, 80)), {3, 3, 94, 74}, threshold);
      for (const cv::Rect& area : areas) found += ExpectThoseOfOpenCv(image, area, threshold);
    }
  }
  EXPECT_GT(found, 1000U);
}

TEST(FastCorners, KeepsNeitherOfTwoNeighboursWithEqualScores) {
  cv::Mat image(40, 40, CV_8UC1, cv::Scalar(10));
  image(cv::Rect(20, 20, 2, 1)).setTo(200);
  EXPECT_EQ(ExpectThoseOfOpenCv(image, {10, 10, 20, 20}, 20), 0U);
  image.at<std::uint8_t>(20, 21) = 190;
  EXPECT_EQ(ExpectThoseOfOpenCv(image, {10, 10, 20, 20}, 20), 1U);
}

TEST(FastCorners, AppendsAndCanBeUsedAgain) {
  internal::FastCorners search;
  const cv::Mat image = SmoothNoise(0.8, 6);
  std::vector<cv::KeyPoint> corners;
  search.Append(image, {3, 3, 154, 114}, 7, &corners);
  const std::size_t first = corners.size();
  search.Append(image, {20, 30, 32, 32}, 7, &corners);
  EXPECT_EQ(corners.size() - first, OfOpenCv(image, {20, 30, 32, 32}, 7).size());
}

}  // namespace
}  // namespace highwall::fast_corners_test
