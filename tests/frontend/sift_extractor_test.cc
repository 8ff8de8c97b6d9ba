#include "features/sift_extractor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

namespace highwall::sift_extractor_test {
namespace {

// Returns a bright spot on grey. centre, sigma: [px]
cv::Mat Blob(const cv::Point2d& centre, double sigma) {
  cv::Mat image(240, 320, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double r2 = (u - centre.x) * (u - centre.x) + (v - centre.y) * (v - centre.y);
      image.at<uchar>(v, u) =
          cv::saturate_cast<uchar>(60.0 + 150.0 * std::exp(-0.5 * r2 / (sigma * sigma)));
    }
  }
  return image;
}

cv::KeyPoint Strongest(const ExtractedPoints& points) {
  return *std::max_element(
      points.keypoints.begin(), points.keypoints.end(),
      [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return a.response < b.response; });
}

TEST(SiftExtractor, FindsABlobWhereItIs) {
  SiftExtractor sift;
  for (const cv::Point2d& centre : {cv::Point2d(160, 120), cv::Point2d(100.4, 80.7)}) {
    for (const double sigma : {2.0, 4.0, 8.0}) {
      const ExtractedPoints points = sift.Extract(Blob(centre, sigma));
      ASSERT_FALSE(points.keypoints.empty()) << sigma;
      const cv::Point2f at = Strongest(points).pt;
      // OpenCV's own keypoints are a quarter of a pixel off along each axis.
      EXPECT_NEAR(static_cast<double>(at.x), centre.x, 0.06) << sigma;
      EXPECT_NEAR(static_cast<double>(at.y), centre.y, 0.06) << sigma;
    }
  }
}

TEST(SiftExtractor, ABlobOfTwiceTheSizeIsThreeLevelsUp) {
  SiftExtractor sift;
  const int level = Strongest(sift.Extract(Blob({160, 120}, 2.2))).octave;
  EXPECT_EQ(Strongest(sift.Extract(Blob({160, 120}, 4.4))).octave, level + 3);
  EXPECT_EQ(Strongest(sift.Extract(Blob({160, 120}, 8.8))).octave, level + 6);
  EXPECT_DOUBLE_EQ(std::pow(sift.kind().pyramid.scale_factor, 3), 2.0);
}

cv::Mat Texture() {
  cv::Mat image(240, 320, CV_8UC1);
  cv::RNG(4).fill(image, cv::RNG::NORMAL, 128, 60);
  cv::GaussianBlur(image, image, {}, 1.5);
  // The left half has ten times the contrast.
  image.colRange(160, 320) = image.colRange(160, 320) * 0.3 + 90;
  return image;
}

TEST(SiftExtractor, KeepsToItsBudgetAndSpreadsIt) {
  SiftExtractor sift({.features = 200, .contrast_threshold = 0.01});
  const ExtractedPoints points = sift.Extract(Texture());
  ASSERT_EQ(points.keypoints.size(), 200U);
  EXPECT_EQ(points.descriptors.size(), cv::Size(128, 200));
  const auto on_the_right = std::ranges::count_if(
      points.keypoints, [](const cv::KeyPoint& k) { return k.pt.x > 160.0F; });
  EXPECT_GT(on_the_right, 60) << "where all the weaker ones are";
  for (const cv::KeyPoint& k : points.keypoints) {
    EXPECT_GE(k.octave, 0);
    EXPECT_LT(k.octave, sift.kind().pyramid.levels);
  }
}

TEST(SiftExtractor, DescriptorsAreRootsOfShares) {
  SiftExtractor sift;
  const ExtractedPoints points = sift.Extract(Texture());
  ASSERT_GT(points.descriptors.rows, 50);
  for (int i = 0; i < points.descriptors.rows; ++i) {
    EXPECT_NEAR(cv::norm(points.descriptors.row(i)), 1.0, 1e-5);
  }
}

TEST(SiftExtractor, FindsNothingInABlankImage) {
  EXPECT_TRUE(SiftExtractor().Extract(cv::Mat(120, 160, CV_8UC1, cv::Scalar(9))).keypoints.empty());
}

TEST(SiftExtractor, RefusesUnusableImagesAndOptions) {
  EXPECT_THROW(SiftExtractor().Extract(cv::Mat(9, 9, CV_8UC3)), InvalidArgument);
  EXPECT_THROW(SiftExtractor().Extract(cv::Mat()), InvalidArgument);
  EXPECT_THROW(SiftExtractor({.features = 0}), InvalidArgument);
  EXPECT_THROW(SiftExtractor({.contrast_threshold = 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::sift_extractor_test
