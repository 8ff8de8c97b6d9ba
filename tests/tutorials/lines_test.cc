// The program of docs/tutorial_lines.md, between the two marks, and its test.
// [tutorial]
#include <vector>

#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/features/line_matcher.h>

// A line that two images show.
struct LineMatch {
  highwall::LineSegment first, second;  // [px] with the brighter side to the left
  int distance;                         // [bit] between the descriptors, 256 at most
};

// Matches the line segments of two images (CV_8UC1) of a camera that moved a little.
std::vector<LineMatch> MatchLines(const cv::Mat& first, const cv::Mat& second) {
  highwall::LbdLineExtractor extractor({.max_lines = 200});
  const highwall::LineFeatures a = extractor.Extract(first);
  const highwall::LineFeatures b = extractor.Extract(second);
  std::vector<LineMatch> matches;
  for (const highwall::FeatureMatch& match : highwall::MatchSmallMotion(a, b)) {
    const auto i = static_cast<std::size_t>(match.query), j = static_cast<std::size_t>(match.train);
    matches.push_back({a.segments[i], b.segments[j], match.distance});
  }
  return matches;
}
// [/tutorial]

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

// Draws a rectangle and a triangle, shifted by (dx, dy) [px].
cv::Mat Shapes(double dx, double dy) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(60));
  const auto at = [&](double x, double y) {
    return cv::Point(static_cast<int>(x + dx), static_cast<int>(y + dy));
  };
  cv::fillConvexPoly(image,
                     std::vector<cv::Point>{at(80, 90), at(300, 90), at(300, 250), at(80, 250)},
                     cv::Scalar(180), cv::LINE_AA);
  cv::fillConvexPoly(image, std::vector<cv::Point>{at(360, 380), at(520, 340), at(450, 140)},
                     cv::Scalar(230), cv::LINE_AA);
  return image;
}

TEST(LinesTutorial, MatchesEachEdgeToItself) {
  const std::vector<LineMatch> matches = MatchLines(Shapes(0.0, 0.0), Shapes(9.0, -6.0));
  EXPECT_EQ(matches.size(), 7u);
  for (const LineMatch& match : matches) {
    const Eigen::Vector2f moved = match.second.Midpoint() - match.first.Midpoint();
    // Edges of whole pixels, sub-pixel accurate; a midpoint may move along its edge.
    EXPECT_LT((moved - Eigen::Vector2f(9.0F, -6.0F)).norm(), 2.0F);
    EXPECT_LT(std::abs(match.second.Angle() - match.first.Angle()), 0.02F);
    EXPECT_LE(match.distance, 80);
  }
}

TEST(LinesTutorial, OfAnImageWithoutLinesThereIsNoMatch) {
  EXPECT_TRUE(MatchLines(Shapes(0.0, 0.0), cv::Mat(480, 640, CV_8UC1, cv::Scalar(60))).empty());
}

}  // namespace
}  // namespace highwall
