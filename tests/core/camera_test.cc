#include <highwall/core/camera.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "random_states.h"
#include "support/message_of.h"

namespace highwall::camera_test {
namespace {

// The distortion that the TUM RGB-D benchmark publishes for freiburg1.
PinholeCamera Freiburg1() {
  const PinholeCamera c{.fx = 517.3,
                        .fy = 516.5,
                        .cx = 318.6,
                        .cy = 255.3,
                        .k1 = 0.2624,
                        .k2 = -0.9531,
                        .p1 = -0.0054,
                        .p2 = 0.0026,
                        .k3 = 1.1633};
  return c;
}

TEST(PinholeCamera, ProjectsByHandWithoutDistortion) {
  const PinholeCamera c{.fx = 500, .fy = 400, .cx = 320, .cy = 240};
  EXPECT_FALSE(c.HasDistortion());
  EXPECT_EQ(c.Project({1, -0.5, 2}), Eigen::Vector2d(570, 140));
  EXPECT_EQ(c.Unproject({570, 140}, 2.0), Eigen::Vector3d(1, -0.5, 2));
}

TEST(PinholeCamera, DistortsByHand) {
  const PinholeCamera c{.k1 = 0.1, .k2 = 0.01, .p1 = 0.02, .p2 = 0.03, .k3 = 0.001};
  // m = (1, 2): r2 = 5, radial = 1 + 0.5 + 0.25 + 0.125 = 1.875.
  // x: 1.875 + 2 * 0.02 * 2 + 0.03 * (5 + 2) = 2.165; y: 3.75 + 0.02 * (5 + 8) + 2 * 0.03 * 2.
  EXPECT_TRUE(c.Distort({1, 2}).isApprox(Eigen::Vector2d(2.165, 4.13), 1e-14));
}

TEST(PinholeCamera, DistortsByHandWithARationalLens) {
  const PinholeCamera c{.k1 = 0.1, .k2 = 0.01, .k3 = 0.001, .k4 = 0.02, .k5 = 0.03, .k6 = 0.004};
  // m = (1, 2): r2 = 5, 1.875 above, 1 + 0.1 + 0.75 + 0.5 = 2.35 below.
  EXPECT_TRUE(c.Distort({1, 2}).isApprox(1.875 / 2.35 * Eigen::Vector2d(1, 2), 1e-14));
}

TEST(PinholeCamera, DistortsByHandWithAFisheye) {
  const PinholeCamera c{
      .k1 = 0.1, .k2 = -0.02, .k3 = 0.003, .k4 = -0.0004, .lens = LensModel::kEquidistant};
  EXPECT_TRUE(c.HasDistortion());
  const double t = std::atan(5.0);  // of m = (3, 4)
  const double bent = t * (1 + 0.1 * t * t - 0.02 * std::pow(t, 4) + 0.003 * std::pow(t, 6) -
                           0.0004 * std::pow(t, 8));
  EXPECT_TRUE(c.Distort({3, 4}).isApprox(bent * Eigen::Vector2d(0.6, 0.8), 1e-14));
  EXPECT_EQ(c.Distort({0, 0}), Eigen::Vector2d(0, 0));
}

// Colour camera of an Azure Kinect at 1280 x 720, and a fisheye of 120 degrees over the width.
PinholeCamera AzureKinect() {
  return {.width = 1280, .height = 720, .fx = 605.7, .fy = 605.6, .cx = 638.1, .cy = 365.9,
          .k1 = 0.5193, .k2 = -2.7132, .p1 = 0.0008, .p2 = -0.0002, .k3 = 1.5744,
          .k4 = 0.3994, .k5 = -2.5405, .k6 = 1.5007};
}

PinholeCamera Fisheye() {
  return {.width = 640, .height = 480, .fx = 300, .fy = 301, .cx = 322, .cy = 238,
          .k1 = 0.02, .k2 = -0.01, .k3 = 0.004, .k4 = -0.001, .lens = LensModel::kEquidistant};
}

TEST(PinholeCamera, UndistortInvertsDistortOfEveryLens) {
  for (const PinholeCamera& c : {AzureKinect(), Fisheye()}) {
    EXPECT_NO_THROW(c.Validate());
    for (int v = 0; v < c.height; v += 13) {
      for (int u = 0; u < c.width; u += 13) {
        const Eigen::Vector2d md((u - c.cx) / c.fx, (v - c.cy) / c.fy);
        EXPECT_LT((c.Distort(c.Undistort(md)) - md).norm(), 1e-12) << u << " " << v;
      }
    }
  }
}

TEST(PinholeCamera, JacobiansOfEveryLensMatchCentralDifferences) {
  RandomStates random(4);
  for (const PinholeCamera& c : {AzureKinect(), Fisheye()}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d m(random.Uniform(-1.0, 1.0), random.Uniform(-0.6, 0.6));
      Eigen::Matrix2d J, numeric;
      c.Distort(m, &J);
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d d = Eigen::Vector2d::Unit(k) * kStep;
        numeric.col(k) = (c.Distort(m + d) - c.Distort(m - d)) / (2.0 * kStep);
      }
      // Rounding of values of about 1 over a step of 1e-6 is 1e-10; curvature adds 1e-11.
      EXPECT_LT((J - numeric).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(PinholeCamera, MapsRaysFarFromTheAxisOfAFisheyeTo80Degrees) {
  const PinholeCamera c{.lens = LensModel::kEquidistant};
  const double radians = 100.0 / 180.0 * 3.141592653589793;
  EXPECT_NEAR(c.Undistort({radians, 0.0}).x(), std::tan(80.0 / 180.0 * 3.141592653589793), 1e-12);
}

TEST(PinholeCamera, UndistortInvertsDistortOverTheWholeImage) {
  const PinholeCamera c = Freiburg1();
  EXPECT_TRUE(c.HasDistortion());
  for (int v = 0; v < c.height; v += 13) {
    for (int u = 0; u < c.width; u += 13) {
      const Eigen::Vector2d md((u - c.cx) / c.fx, (v - c.cy) / c.fy);
      EXPECT_LT((c.Distort(c.Undistort(md)) - md).norm(), 1e-12) << u << " " << v;
    }
  }
}

TEST(PinholeCamera, UnprojectInvertsProject) {
  RandomStates random(1);
  const PinholeCamera c = Freiburg1();
  for (int i = 0; i < 100; ++i) {
    const double z = random.Uniform(0.3, 8.0);
    const Eigen::Vector3d p(random.Uniform(-0.5, 0.5) * z, random.Uniform(-0.4, 0.4) * z, z);
    EXPECT_TRUE(c.Unproject(c.Project(p), z).isApprox(p, 1e-11));
  }
}

TEST(PinholeCamera, UndistortedPixelsAreThoseOfTheCameraWithoutDistortion) {
  RandomStates random(2);
  const PinholeCamera c = Freiburg1();
  EXPECT_FALSE(c.WithoutDistortion().HasDistortion());
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p(random.Uniform(-0.5, 0.5), random.Uniform(-0.4, 0.4), 1.0);
    EXPECT_LT((c.UndistortPixel(c.Project(p)) - c.WithoutDistortion().Project(p)).norm(), 1e-9);
  }
}

TEST(PinholeCamera, ProjectionJacobianMatchesCentralDifferences) {
  RandomStates random(3);
  const PinholeCamera c = Freiburg1();
  for (int i = 0; i < 50; ++i) {
    const double z = random.Uniform(0.5, 5.0);
    const Eigen::Vector3d p(random.Uniform(-0.5, 0.5) * z, random.Uniform(-0.4, 0.4) * z, z);
    Eigen::Matrix<double, 2, 3> J, numeric;
    c.Project(p, &J);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = Eigen::Vector3d::Unit(k) * h;
      numeric.col(k) = (c.Project(p + d) - c.Project(p - d)) / (2.0 * h);
    }
    // Rounding of pixels of about 640 over a step of 1e-6 is 1e-7.
    EXPECT_LT((J - numeric).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(PinholeCamera, ContainsPixelCentresUpToTheLast) {
  const PinholeCamera c;
  EXPECT_TRUE(c.Contains({0, 0}));
  EXPECT_TRUE(c.Contains({639, 479}));
  EXPECT_FALSE(c.Contains({639.5, 479}));
  EXPECT_FALSE(c.Contains({-0.1, 10}));
  EXPECT_FALSE(c.Contains({4, 10}, 5.0));
  EXPECT_TRUE(c.Contains({634, 10}, 5.0));
  EXPECT_FALSE(c.Contains({std::numeric_limits<double>::quiet_NaN(), 10}));
}

TEST(PinholeCamera, ValidateNamesTheField) {
  EXPECT_NO_THROW(Freiburg1().Validate());
  const auto message = [](auto change) {
    PinholeCamera c;
    change(c);
    return testing::MessageOf<InvalidArgument>([&] { c.Validate(); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto npos = std::string::npos;
  EXPECT_NE(message([](auto& c) { c.width = 0; }).find("::width"), npos);
  EXPECT_NE(message([](auto& c) { c.height = -1; }).find("::height"), npos);
  EXPECT_NE(message([](auto& c) { c.fx = 0; }).find("::fx"), npos);
  EXPECT_NE(message([=](auto& c) { c.fy = nan; }).find("::fy"), npos);
  EXPECT_NE(message([=](auto& c) { c.cx = nan; }).find("::cx"), npos);
  EXPECT_NE(message([=](auto& c) { c.k3 = nan; }).find("distortion"), npos);
  EXPECT_NE(message([=](auto& c) { c.k6 = nan; }).find("distortion"), npos);
  EXPECT_NE(message([=](auto& c) {
              c.lens = LensModel::kEquidistant;
              c.p1 = 0.1;
            }).find("equidistant"),
            npos);
}

TEST(VirtualRightCamera, DisparityAndDepthAreInverse) {
  const VirtualRightCamera right{.fx = 500, .baseline = 0.08};
  EXPECT_DOUBLE_EQ(right.Disparity(2.0), 20.0);
  EXPECT_DOUBLE_EQ(right.Depth(20.0), 2.0);
}

}  // namespace
}  // namespace highwall::camera_test
