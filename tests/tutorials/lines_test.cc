// The program of docs/tutorial_lines.md.
#include "examples/lines/match_lines.h"

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
