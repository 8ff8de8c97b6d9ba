#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "features/edge_lines.h"

namespace highwall::edge_lines_test {
namespace {

constexpr float kMinLength = 12.0F;

std::vector<LineSegment> Detect(const cv::Mat& image) {
  return internal::EdgeLines().Detect(internal::ImageGradient(image), kMinLength);
}

// A bright rectangle on dark ground, turned about the middle of 320 x 240 px. Its sides are steps
// under a Gaussian blur.
class TurnedRectangle {
 public:
  explicit TurnedRectangle(float degrees)
      : R_(Eigen::Rotation2Df(degrees * std::numbers::pi_v<float> / 180.0F)) {}

  cv::Mat Draw() const {
    cv::Mat image(240, 320, CV_8U);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector2f p =
            R_.inverse() *
            (Eigen::Vector2f(static_cast<float>(u), static_cast<float>(v)) - kMiddle);
        const float inside =
            Inside(kHalf.x() - std::abs(p.x())) * Inside(kHalf.y() - std::abs(p.y()));
        image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(50.0F + 130.0F * inside);
      }
    }
    return image;
  }
  // Side i, with the bright side to the left.
  LineSegment Side(std::size_t i) const { return {Corner((i + 1) % 4), Corner(i)}; }

 private:
  static float Inside(float depth) {
    return 0.5F * std::erfc(-depth / (0.8F * std::numbers::sqrt2_v<float>));
  }
  Eigen::Vector2f Corner(std::size_t i) const {
    const Eigen::Vector2f sign(i == 1 || i == 2 ? 1.0F : -1.0F, i >= 2 ? 1.0F : -1.0F);
    return kMiddle + R_ * Eigen::Vector2f(sign.cwiseProduct(kHalf));
  }

  const Eigen::Vector2f kMiddle{160.3F, 120.7F}, kHalf{95.0F, 70.0F};
  Eigen::Rotation2Df R_;
};

float Distance(const Eigen::Vector2f& p, const LineSegment& line) {
  const Eigen::Vector2f d = (line.e - line.s).normalized(), q = p - line.s;
  return std::abs(d.x() * q.y() - d.y() * q.x());
}

// [degrees] between the directions.
float AngleBetween(const LineSegment& p, const LineSegment& q) {
  const Eigen::Vector2f a = p.e - p.s, b = q.e - q.s;
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b))) * 180.0F /
         std::numbers::pi_v<float>;
}

cv::Mat Noise(int rows, int cols, double sigma, std::uint64_t seed) {
  cv::Mat noise(rows, cols, CV_32F), image;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 128.0, sigma);
  noise.convertTo(image, CV_8U);
  return image;
}

bool Equal(const std::vector<LineSegment>& a, const std::vector<LineSegment>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& p, const auto& q) { return p.s == q.s && p.e == q.e; });
}

TEST(EdgeLines, FindsTheSidesOfARectangleToAFractionOfAPixel) {
  for (const auto& [degrees, rounding] : {std::pair(0.0F, 0.5F),
                                          {7.0F, 0.0F},
                                          {30.0F, 0.0F},
                                          {45.0F, 0.36F},
                                          {63.0F, 0.0F},
                                          {90.0F, 0.5F}}) {
    const TurnedRectangle shape(degrees);
    const std::vector<LineSegment> lines = Detect(shape.Draw());
    EXPECT_EQ(lines.size(), 4U) << degrees;
    for (std::size_t i = 0; i < 4; ++i) {
      const LineSegment side = shape.Side(i);
      const auto found = std::find_if(lines.begin(), lines.end(), [&](const LineSegment& line) {
        return Distance(line.s, side) < 1.5F && Distance(line.e, side) < 1.5F;
      });
      ASSERT_NE(found, lines.end()) << degrees << ", side " << i;
      // Chains consist of whole pixels. Where a side crosses rows, their roundings cancel; one that
      // follows a row or a diagonal may be half of their distance away.
      const Eigen::Vector2f middle = 0.5F * (found->s + found->e);
      EXPECT_LT(Distance(middle, side), rounding + 0.1F) << degrees << ", side " << i;
      EXPECT_LT(AngleBetween(*found, side), 0.2F) << degrees << ", side " << i;
      EXPECT_GT(found->Length(), 0.93F * side.Length()) << degrees;
      EXPECT_LT(found->Length(), 1.01F * side.Length()) << degrees;
      EXPECT_GT((found->e - found->s).dot(side.e - side.s), 0.0F) << degrees;
    }
  }
}

// Blur rounds a corner over some three pixels, and both sides end there.
TEST(EdgeLines, SidesEndAtTheCorners) {
  for (const float degrees : {0.0F, 7.0F, 30.0F, 45.0F}) {
    const TurnedRectangle shape(degrees);
    const std::vector<LineSegment> lines = Detect(shape.Draw());
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2f corner = shape.Side(i).s;
      float start = 1e3F, end = 1e3F;
      for (const LineSegment& line : lines) {
        start = std::min(start, (line.s - corner).norm());
        end = std::min(end, (line.e - corner).norm());
      }
      EXPECT_LT(std::max(start, end), 5.0F) << degrees << ", corner " << i;
    }
  }
}

// Walls of 4 px with gaps of 8 px wind to the middle: one edge on each side of them.
TEST(EdgeLines, FindsEachSideOfASpiral) {
  cv::Mat image(360, 360, CV_8U, cv::Scalar(40));
  constexpr int kPitch = 12, kWall = 4;
  const auto wall = [&](int x0, int y0, int x1, int y1) {
    image(cv::Rect(cv::Point(x0, y0), cv::Point(x1, y1))).setTo(180);
  };
  int low = 10, high = 350;
  std::size_t walls = 0;
  for (; high - low > 60; low += kPitch, high -= kPitch, walls += 4) {
    wall(low, low, high, low + kWall);
    wall(high - kWall, low, high, high);
    wall(low, high - kWall, high, high);
    wall(low, low + kPitch, low + kWall, high);                   // open at the top
    wall(low, low + kPitch, low + kPitch, low + kPitch + kWall);  // on to the next turn
  }
  std::size_t found = 0;
  for (const LineSegment& line : Detect(image)) {
    const Eigen::Vector2f d = (line.e - line.s).cwiseAbs();
    EXPECT_LT(d.minCoeff(), 0.5F);  // all are level or upright
    found += d.maxCoeff() > 40.0F ? 1 : 0;
  }
  EXPECT_EQ(found, 2 * walls);
}

TEST(EdgeLines, FindsNoneInTheNoiseOfACamera) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_TRUE(Detect(Noise(240, 320, 5.0, seed)).empty()) << seed;
  }
}

// Neighbouring gradients of blurred noise are correlated: a chain of a dozen pixels may be
// straight.
TEST(EdgeLines, FindsNoLongOnesInStrongNoise) {
  std::size_t lines = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<LineSegment> found = Detect(Noise(240, 320, 40.0, seed));
    lines += found.size();
    for (const LineSegment& line : found) EXPECT_LT(line.Length(), 25.0F) << seed;
  }
  EXPECT_LT(lines, 40U);
}

TEST(EdgeLines, FindsAnEdgeThatRunsThroughTheBorder) {
  cv::Mat image(120, 160, CV_8U, cv::Scalar(40));
  image.rowRange(60, 120).setTo(160);
  const std::vector<LineSegment> lines = Detect(image);
  ASSERT_EQ(lines.size(), 1U);
  // The bright side is below, and to the left of a line that runs to the left.
  EXPECT_LE((lines[0].s - Eigen::Vector2f(159.0F, 59.5F)).norm(), 1.2F);
  EXPECT_LE((lines[0].e - Eigen::Vector2f(0.0F, 59.5F)).norm(), 1.2F);
}

TEST(EdgeLines, TheBorderIsNoEdge) {
  for (const int value : {0, 255}) {
    EXPECT_TRUE(Detect(cv::Mat(120, 160, CV_8U, cv::Scalar(value))).empty());
  }
  // Steps that are a pixel from the border.
  cv::Mat framed(120, 160, CV_8U, cv::Scalar(200));
  framed(cv::Rect(1, 1, 158, 118)).setTo(60);
  for (const LineSegment& line : Detect(framed)) {
    for (const Eigen::Vector2f& end : {line.s, line.e}) {
      EXPECT_TRUE(end.x() >= 0.0F && end.y() >= 0.0F && end.x() <= 159.0F && end.y() <= 119.0F);
    }
  }
}

TEST(EdgeLines, FindsNoneInImagesOfFewPixels) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 200), cv::Size(200, 1), cv::Size(2, 200),
                              cv::Size(200, 2), cv::Size(3, 3), cv::Size(7, 5)}) {
    EXPECT_TRUE(Detect(Noise(size.height, size.width, 60.0, 3)).empty()) << size;
  }
}

TEST(EdgeLines, ACircleGivesOnlyShortLines) {
  cv::Mat image(240, 320, CV_8U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double inside = 60.0 - std::hypot(u - 160.2, v - 120.6);
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(100.0 + 50.0 * std::tanh(inside));
    }
  }
  for (const LineSegment& line : Detect(image)) EXPECT_LT(line.Length(), 45.0F);
}

TEST(EdgeLines, DependsOnNothingButTheImage) {
  const cv::Mat image = TurnedRectangle(20.0F).Draw();
  internal::EdgeLines used;
  const std::vector<LineSegment> first = used.Detect(internal::ImageGradient(image), kMinLength);
  EXPECT_FALSE(first.empty());
  used.Detect(internal::ImageGradient(Noise(100, 400, 60.0, 1)), kMinLength);
  used.Detect(internal::ImageGradient(Noise(240, 320, 60.0, 2)), kMinLength);
  EXPECT_TRUE(Equal(used.Detect(internal::ImageGradient(image), kMinLength), first));
  EXPECT_TRUE(Equal(Detect(image), first));
}

// Rows of a part of an image do not follow one another in memory.
TEST(EdgeLines, APartOfAnImageIsAnImage) {
  const cv::Mat part = TurnedRectangle(20.0F).Draw()(cv::Rect(31, 17, 203, 151));
  ASSERT_FALSE(part.isContinuous());
  const std::vector<LineSegment> lines = Detect(part);
  EXPECT_FALSE(lines.empty());
  EXPECT_TRUE(Equal(lines, Detect(part.clone())));
}

// Of any length that is asked for, down to windows of three pixels.
TEST(EdgeLines, NoneIsShorterThanAskedForOrOutsideOfTheImage) {
  for (const float min_length : {3.0F, 8.0F, 25.6F}) {
    for (const cv::Size size : {cv::Size(64, 48), cv::Size(17, 90), cv::Size(5, 5)}) {
      const internal::ImageGradient gradient(Noise(size.height, size.width, 60.0, 5));
      for (const LineSegment& line : internal::EdgeLines().Detect(gradient, min_length)) {
        EXPECT_GE(line.Length(), min_length);
        for (const Eigen::Vector2f& p : {line.s, line.e}) {
          EXPECT_TRUE(p.minCoeff() >= 0.0F && p.x() <= static_cast<float>(size.width - 1) &&
                      p.y() <= static_cast<float>(size.height - 1));
        }
      }
    }
  }
}

}  // namespace
}  // namespace highwall::edge_lines_test
