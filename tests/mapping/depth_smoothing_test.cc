#include <highwall/mapping/depth_smoothing.h>

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall::depth_smoothing_test {
namespace {

constexpr double kFocal = 100.0;  // [px]
constexpr int kWidth = 80, kHeight = 60;

// sigma(z) = 5 mm z^2.
double Sigma(double z) {
  return 0.005 * z * z;
}

// A plane that recedes to the right, 1 / z = 0.5 - 0.004 u, from 2 m to 5.4 m.
float PlaneDepth(int u) {
  return 1.0f / (0.5f - 0.004f * static_cast<float>(u));
}

// The plane with independent noise in each pixel.
cv::Mat Plane(bool noisy) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  cv::Mat depth(kHeight, kWidth, CV_32FC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const float z = PlaneDepth(u);
      depth.at<float>(v, u) = z + (noisy ? static_cast<float>(Sigma(z) * normal(rng)) : 0.0f);
    }
  }
  return depth;
}

// Returns the root mean square error in sigmas, away from the border of the image.
double ErrorOf(const cv::Mat& depth) {
  double squares = 0.0;
  int count = 0;
  for (int v = 10; v < kHeight - 10; ++v) {
    for (int u = 10; u < kWidth - 10; ++u, ++count) {
      const double z = PlaneDepth(u);
      squares += std::pow((depth.at<float>(v, u) - z) / Sigma(z), 2);
    }
  }
  return std::sqrt(squares / count);
}

TEST(SmoothDepth, LeavesAPlaneWithoutNoiseAsItIs) {
  const cv::Mat plane = Plane(false);
  // Slopes of the inverse depth cancel in a symmetric window, and only rounding remains.
  EXPECT_LT(ErrorOf(SmoothDepth(plane, kFocal, Sigma)), 1e-3);
}

TEST(SmoothDepth, TakesMostOfTheNoiseOffAPlane) {
  const cv::Mat plane = Plane(true);
  EXPECT_NEAR(ErrorOf(plane), 1.0, 0.05);
  // A window of 25 pixels reduces the noise to a fifth, plus a little for the gate around a noisy
  // centre.
  EXPECT_LT(ErrorOf(SmoothDepth(plane, kFocal, Sigma, {.max_extent = 1.0})), 0.3);
}

TEST(SmoothDepth, AFactorOnTheNoiseIsThatOnSigma) {
  const cv::Mat plane = Plane(true), twice(kHeight, kWidth, CV_32FC1, cv::Scalar(2.0));
  // The size of a window is tabulated by depth in steps of 2 cm; here the bounds decide.
  const DepthSmoothingOptions options{.target_sigma = 1e-4, .max_extent = 1.0};
  const auto of_twice = [](double z) { return 2.0 * Sigma(z); };
  const cv::Mat expected = SmoothDepth(plane, kFocal, of_twice, options);
  const cv::Mat smooth = SmoothDepth(plane, kFocal, Sigma, options, twice);
  // The gates differ by the step of the table, 1 %, which decides on a few noisy pairs.
  EXPECT_LT(std::abs(ErrorOf(smooth) / ErrorOf(expected) - 1.0), 0.01);
  EXPECT_GT(std::abs(ErrorOf(SmoothDepth(plane, kFocal, Sigma, options)) / ErrorOf(expected) - 1.0),
            0.02);
  EXPECT_THROW(SmoothDepth(plane, kFocal, Sigma, options, twice.rowRange(0, 4)), InvalidArgument);
}

TEST(SmoothDepth, KeepsTheEdgeBetweenTwoSurfaces) {
  cv::Mat depth(kHeight, kWidth, CV_32FC1, cv::Scalar(2.0));
  depth.colRange(kWidth / 2, kWidth).setTo(3.0);
  const cv::Mat smooth = SmoothDepth(depth, kFocal, Sigma, {.max_extent = 1.0});
  EXPECT_LT(cv::norm(smooth, depth, cv::NORM_INF), 1e-5);  // rounding of the inverse depth
}

// The window of a pixel depends on its own depth, also if that is the largest of the image and at
// the border of two depth steps: a farther pixel outside all windows changes nothing.
TEST(SmoothDepth, TheFarthestPixelIsSmoothedLikeAnyOther) {
  const DepthSmoothingOptions options{.target_sigma = 1e-6, .max_extent = 1.0, .max_radius = 2};
  for (int step = 5; step <= 500; ++step) {
    const float z = static_cast<float>(0.02 * step);  // [m]
    cv::Mat wall(11, 11, CV_32FC1, cv::Scalar(z));
    for (int v = 0; v < wall.rows; ++v) {
      for (int u = v % 2; u < wall.cols; u += 2) {
        wall.at<float>(v, u) = z - static_cast<float>(Sigma(z));
      }
    }
    cv::Mat with_more = wall.clone();
    with_more.at<float>(0, 0) = z + 1.0f;
    const cv::Rect inside(3, 3, 8, 8);
    const cv::Mat alone = SmoothDepth(wall, kFocal, Sigma, options)(inside);
    const cv::Mat expected = SmoothDepth(with_more, kFocal, Sigma, options)(inside);
    EXPECT_EQ(cv::norm(alone, expected, cv::NORM_INF), 0.0) << z;
    EXPECT_GT(cv::norm(alone, wall(inside), cv::NORM_INF), 0.0) << z;
  }
}

TEST(SmoothDepth, DoesNothingWhereTheSensorIsGoodEnough) {
  const cv::Mat plane = Plane(true);
  const cv::Mat smooth = SmoothDepth(plane, kFocal, Sigma, {.target_sigma = 1.0});
  EXPECT_EQ(cv::norm(smooth, plane, cv::NORM_INF), 0.0);
  const cv::Mat off = SmoothDepth(plane, kFocal, Sigma, {.max_radius = 0});
  EXPECT_EQ(cv::norm(off, plane, cv::NORM_INF), 0.0);
}

TEST(SmoothDepth, LeavesHolesOpenAndOutOfTheMeans) {
  cv::Mat depth(kHeight, kWidth, CV_32FC1, cv::Scalar(4.0));
  depth.at<float>(30, 40) = 0.0f;
  depth.at<float>(30, 44) = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat smooth = SmoothDepth(depth, kFocal, Sigma, {.max_extent = 1.0});
  EXPECT_EQ(smooth.at<float>(30, 40), 0.0f);
  EXPECT_TRUE(std::isnan(smooth.at<float>(30, 44)));
  EXPECT_NEAR(smooth.at<float>(30, 41), 4.0f, 1e-5);
  EXPECT_NEAR(smooth.at<float>(30, 43), 4.0f, 1e-5);
  EXPECT_TRUE(SmoothDepth(cv::Mat(), kFocal, Sigma).empty());
}

TEST(SmoothDepth, RefusesOtherImagesAndOptionsOutOfRange) {
  const cv::Mat depth = Plane(false);
  EXPECT_THROW(SmoothDepth(cv::Mat(4, 4, CV_16UC1), kFocal, Sigma), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, 0.0, Sigma), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, kFocal, Sigma, {.target_sigma = 0.0}), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, kFocal, Sigma, {.max_extent = 0.0}), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, kFocal, Sigma, {.max_radius = -1}), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, kFocal, Sigma, {.grain = 0.0}), InvalidArgument);
  EXPECT_THROW(SmoothDepth(depth, kFocal, Sigma, {.gate = 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::depth_smoothing_test
