#include "input/depth_registration.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall::depth_registration_test {
namespace {

// A wall z = 2 + 0.2 x, and in front of it a board z = 1 for |x| < 0.15, |y| < 0.1, in the frame of
// the colour camera.
double DepthAlong(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  // origin + t ray
  const double board = (1.0 - origin.z()) / ray.z();
  const Eigen::Vector3d on_board = origin + board * ray;
  if (board > 0.0 && std::abs(on_board.x()) < 0.15 && std::abs(on_board.y()) < 0.1) return board;
  return (2.0 + 0.2 * origin.x() - origin.z()) / (ray.z() - 0.2 * ray.x());
}

// Depth images of a camera at T_CX, exact at the centre of each pixel.
cv::Mat Render(const PinholeCamera& camera, const Pose& T_CX) {
  cv::Mat depth(camera.height, camera.width, CV_32FC1);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = T_CX.R() * camera.Unproject(Eigen::Vector2d(u, v), 1.0);
      depth.at<float>(v, u) = static_cast<float>(DepthAlong(T_CX.p(), ray));
    }
  }
  return depth;
}

PinholeCamera Camera(int width, int height, double focal) {
  return {.width = width,
          .height = height,
          .fx = focal,
          .fy = focal,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1)};
}

// 5 cm and 1 degree beside the colour camera.
Pose Beside() {
  return Pose(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 180.0, Eigen::Vector3d::UnitY())),
              Eigen::Vector3d(0.05, 0.0, 0.0));
}

struct Agreement {
  double holes = 0.0, wrong = 0.0, error = 0.0;  // shares of the pixels; mean of the right ones [m]
};

Agreement Compare(const cv::Mat& registered, const cv::Mat& expected) {
  constexpr double kOneSurface = 0.1;  // [m] the surfaces are 0.9 m apart
  Agreement agreement;
  double right = 0.0;
  for (int v = 0; v < expected.rows; ++v) {
    for (int u = 0; u < expected.cols; ++u) {
      const double z = registered.at<float>(v, u), difference = z - expected.at<float>(v, u);
      if (z == 0.0) {
        agreement.holes += 1.0;
      } else if (std::abs(difference) > kOneSurface) {
        agreement.wrong += 1.0;
      } else {
        right += 1.0;
        agreement.error += std::abs(difference);
      }
    }
  }
  const double all = static_cast<double>(expected.total());
  return {agreement.holes / all, agreement.wrong / all, agreement.error / right};
}

TEST(DepthRegistration, OfTheSameCameraChangesNothing) {
  const PinholeCamera camera = Camera(64, 48, 60.0);
  const cv::Mat depth = Render(camera, Pose());
  const cv::Mat registered = DepthRegistration(camera, {.camera = camera}).Register(depth);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      // Rounding of floats.
      EXPECT_NEAR(registered.at<float>(v, u), depth.at<float>(v, u), 1e-5) << u << " " << v;
    }
  }
}

TEST(DepthRegistration, PutsReadingsWhereTheColourCameraSeesThem) {
  // As in a D435: a wider view of fewer pixels.
  const PinholeCamera colour = Camera(640, 360, 460.0), depth = Camera(424, 240, 213.0);
  const DepthRegistration registration(colour, {.camera = depth, .T_CD = Beside()});
  const Agreement agreement =
      Compare(registration.Register(Render(depth, Beside())), Render(colour, Pose()));
  EXPECT_LT(agreement.error, 0.001);  // the wall is plane: interpolation hardly errs
  EXPECT_LT(agreement.wrong, 0.01);   // the board's edge, half a depth pixel wide
  // 5 cm to the right, the depth camera does not see what the board hides on its left: 11 px of 92
  // rows, and at most as much beside the edge of its own view.
  EXPECT_LT(agreement.holes, 0.05);
}

TEST(DepthRegistration, InterpolatesWithinASurfaceWhereDepthPixelsAreLarge) {
  const PinholeCamera colour = Camera(960, 720, 800.0), depth = Camera(128, 96, 106.0);
  const DepthRegistration registration(colour, {.camera = depth});
  const Agreement agreement =
      Compare(registration.Register(Render(depth, Pose())), Render(colour, Pose()));
  // Steps of whole depth pixels would err by 0.2 x 2 m / 106 / 4 = 1 mm in the mean.
  EXPECT_LT(agreement.error, 0.0002);
  EXPECT_LT(agreement.wrong, 0.01);
}

TEST(DepthRegistration, KeepsTheNearestReadingAndHoles) {
  const PinholeCamera camera = Camera(8, 6, 8.0);
  // Of four times the focal length: its columns 2 and 3 fall on column 3, at 3.1 and 3.4.
  const DepthRegistration registration(camera, {.camera = Camera(8, 6, 32.0)});
  cv::Mat depth = cv::Mat::zeros(6, 8, CV_32FC1);
  depth.at<float>(2, 2) = 2.0F;
  depth.at<float>(2, 3) = 3.0F;
  depth.at<float>(3, 3) = std::numeric_limits<float>::quiet_NaN();
  cv::Mat expected = cv::Mat::zeros(6, 8, CV_32FC1);
  expected.at<float>(2, 3) = 2.0F;
  EXPECT_EQ(cv::norm(registration.Register(depth), expected, cv::NORM_INF), 0.0);
}

TEST(DepthRegistration, TheNoiseFactorIsThatOfTheReadingThatIsKept) {
  const PinholeCamera camera = Camera(8, 6, 8.0);
  const DepthRegistration registration(camera, {.camera = Camera(8, 6, 32.0)});
  for (const bool first_is_near : {true, false}) {
    // Both fall on column 3.
    cv::Mat depth = cv::Mat::zeros(6, 8, CV_32FC1), factor(6, 8, CV_32FC1, cv::Scalar(9.0));
    depth.at<float>(2, 2) = first_is_near ? 2.0F : 3.0F;
    depth.at<float>(2, 3) = first_is_near ? 3.0F : 2.0F;
    factor.at<float>(2, 2) = 4.0F;
    factor.at<float>(2, 3) = 5.0F;
    EXPECT_EQ(registration.Register(depth, &factor).at<float>(2, 3), 2.0F);
    cv::Mat expected(6, 8, CV_32FC1, cv::Scalar(1.0));
    expected.at<float>(2, 3) = first_is_near ? 4.0F : 5.0F;
    EXPECT_EQ(cv::norm(factor, expected, cv::NORM_INF), 0.0);
  }
}

TEST(DepthRegistration, TheNoiseFactorOfAnInterpolatedDepthIsThatOfTheNextReading) {
  const PinholeCamera colour = Camera(960, 720, 800.0), depth = Camera(128, 96, 106.0);
  const DepthRegistration registration(colour, {.camera = depth});
  cv::Mat factor(96, 128, CV_32FC1, cv::Scalar(1.0));
  factor.colRange(64, 128).setTo(2.0);
  const cv::Mat wall(96, 128, CV_32FC1, cv::Scalar(2.0));
  const cv::Mat registered = registration.Register(wall, &factor);
  EXPECT_EQ(cv::norm(registered, registration.Register(wall), cv::NORM_INF), 0.0);
  ASSERT_EQ(factor.size(), registered.size());
  for (int v = 0; v < factor.rows; ++v) {
    for (int u = 0; u < factor.cols; ++u) {
      const bool is_right = u >= 480 && registered.at<float>(v, u) > 0.0F;
      ASSERT_EQ(factor.at<float>(v, u), is_right ? 2.0F : 1.0F) << u << " " << v;
    }
  }
}

TEST(DepthRegistration, FollowsTheDistortionOfBothLenses) {
  PinholeCamera colour = Camera(320, 240, 260.0), depth = Camera(320, 240, 250.0);
  colour.k1 = 0.1;
  depth.k1 = -0.2;
  const DepthRegistration registration(colour, {.camera = depth, .T_CD = Beside()});
  const Agreement agreement =
      Compare(registration.Register(Render(depth, Beside())), Render(colour, Pose()));
  EXPECT_LT(agreement.error, 0.002);
  EXPECT_LT(agreement.wrong, 0.02);
}

TEST(DepthRegistration, DoesNotFoldWhatTheColourCameraDoesNotSeeIntoItsImage) {
  PinholeCamera colour = Camera(320, 240, 260.0);
  colour.k1 = -0.3;  // beyond 1.05 from the axis, at z = 1, the model bends rays back
  const PinholeCamera wide = Camera(320, 240, 100.0);  // up to 1.6
  cv::Mat depth = cv::Mat::zeros(240, 320, CV_32FC1);
  depth.colRange(0, 40).setTo(2.0F);  // 1.2 to 1.6 from the axis
  const cv::Mat registered = DepthRegistration(colour, {.camera = wide}).Register(depth);
  EXPECT_EQ(cv::countNonZero(registered), 0);
}

TEST(DepthRegistration, RefusesImagesOfAnotherSize) {
  const PinholeCamera camera = Camera(8, 6, 8.0);
  const DepthRegistration registration(camera, {.camera = camera});
  EXPECT_THROW(registration.Register(cv::Mat::zeros(5, 8, CV_32FC1)), InvalidArgument);
  EXPECT_THROW(registration.Register(cv::Mat::zeros(6, 8, CV_16UC1)), InvalidArgument);
  cv::Mat factor = cv::Mat::ones(5, 8, CV_32FC1);
  EXPECT_THROW(registration.Register(cv::Mat::zeros(6, 8, CV_32FC1), &factor), InvalidArgument);
}

}  // namespace
}  // namespace highwall::depth_registration_test
