#include "input/depth_unit.h"

#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/message_of.h"

namespace highwall::depth_unit_test {
namespace {

// Returns 100 x 100 readings of `depth`, the first `others` of which are `other`.
cv::Mat Depth(float depth, int others, float other) {
  cv::Mat image(100, 100, CV_32FC1, depth);
  for (int i = 0; i < others; ++i) image.at<float>(i / 100, i % 100) = other;
  return image;
}

TEST(IsMetric, IsSeenWhereATenthLiesWithin100Metres) {
  EXPECT_TRUE(IsMetric(Depth(2.0F, 0, 0.0F)));
  EXPECT_TRUE(IsMetric(Depth(100.0F, 0, 0.0F)));
  // A stereo camera under the open sky.
  EXPECT_TRUE(IsMetric(Depth(5000.0F, 1000, 8.0F)));
  EXPECT_TRUE(IsMetric(Depth(std::numeric_limits<float>::infinity(), 200, 3.0F)));
}

TEST(IsMetric, IsNotDecidedByAFewReadings) {
  for (const int near : {1, 100, 999}) {
    const auto ask = [near] { (void)IsMetric(Depth(2000.0F, near, 50.0F)); };
    testing::ExpectError("of it lies beyond 100 m (median 2000 m)", ask);
  }
  const auto ask = [] { (void)IsMetric(Depth(2000.0F, 999, 50.0F)); };
  testing::ExpectError("but 90 % of it", ask);
  testing::ExpectError("but all of it", [] { (void)IsMetric(Depth(2000.0F, 0, 0.0F)); });
}

TEST(IsMetric, IsOpenWhereHardlyAPixelHasAReading) {
  EXPECT_FALSE(IsMetric(Depth(0.0F, 0, 0.0F)));
  EXPECT_FALSE(IsMetric(Depth(0.0F, 99, 2.0F)));
  EXPECT_FALSE(IsMetric(Depth(0.0F, 99, 2000.0F)));
  EXPECT_FALSE(IsMetric(cv::Mat()));
}

}  // namespace
}  // namespace highwall::depth_unit_test
