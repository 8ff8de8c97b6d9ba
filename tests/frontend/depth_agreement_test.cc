#include <functional>

#include <gtest/gtest.h>

#include "pose/depth_agreement.h"

namespace highwall::depth_agreement_test {
namespace {

PinholeCamera Camera() {
  return {.width = 640, .height = 480, .fx = 525, .fy = 525, .cx = 319.5, .cy = 239.5};
}

class DepthComparisonTest : public ::testing::Test {
 protected:
  // Returns the view of a camera in which `depth` gives the depth of each ray.
  cv::Mat View(const std::function<double(const Eigen::Vector3d& ray)>& depth) const {
    cv::Mat view(grid.camera().height, grid.camera().width, CV_32FC1);
    for (int v = 0; v < view.rows; ++v) {
      for (int u = 0; u < view.cols; ++u) {
        view.at<float>(v, u) = static_cast<float>(depth(grid.Ray({u, v}).cast<double>()));
      }
    }
    return view;
  }
  cv::Mat Wall(double z) const {
    return View([z](const Eigen::Vector3d&) { return z; });
  }
  // Returns the view of a wall at 3 m and, in front of it at 2 m, a box that covers x/z from `left`
  // to `right`.
  cv::Mat Box(double left, double right) const {
    return View([=](const Eigen::Vector3d& ray) {
      return ray.x() >= left && ray.x() <= right ? 2.0 : 3.0;
    });
  }
  std::optional<double> Contradiction(const cv::Mat& a, const cv::Mat& b,
                                      const Pose& T_AB = Pose()) const {
    DepthComparison comparison(grid, DepthNoise::Kinect());
    comparison.Add(a, b, T_AB);
    return comparison.Contradiction();
  }

  const DepthGrid grid{Camera()};
};

TEST_F(DepthComparisonTest, OnePlaceContradictsNothing) {
  EXPECT_EQ(Contradiction(Box(-0.2, 0.2), Box(-0.2, 0.2)), 0.0);
  // The camera is half a metre nearer to the same wall.
  EXPECT_EQ(Contradiction(Wall(3.0), Wall(2.5), Pose(Eigen::Quaterniond::Identity(), {0, 0, 0.5})),
            0.0);
}

TEST_F(DepthComparisonTest, AppearedOrVanishedObjectsAreNoContradiction) {
  EXPECT_EQ(Contradiction(Wall(3.0), Box(-0.3, 0.3)), 0.0);
  EXPECT_EQ(Contradiction(Box(-0.3, 0.3), Wall(3.0)), 0.0);
}

TEST_F(DepthComparisonTest, APlaceWithTheSameThingsElsewhereIsAnother) {
  // The boxes cover a third of 1.2 in x/z on either side.
  const auto share = Contradiction(Box(-0.5, -0.1), Box(0.1, 0.5));
  ASSERT_TRUE(share);
  EXPECT_NEAR(*share, 0.4 / 1.22, 0.04);  // the borders of the boxes are left out
}

TEST_F(DepthComparisonTest, AWrongDistanceContradictsOneWay) {
  // One camera looks through the wall of the other, which lies behind.
  EXPECT_EQ(Contradiction(Wall(3.0), Wall(2.0)), 0.0);
}

TEST_F(DepthComparisonTest, WithoutReadingsOrOverlapItSaysNothing) {
  EXPECT_FALSE(Contradiction(cv::Mat(), Wall(3.0)));
  EXPECT_FALSE(Contradiction(Wall(0.0), Wall(3.0)));
  const Eigen::Quaterniond behind(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()));
  EXPECT_FALSE(Contradiction(Wall(3.0), Wall(3.0), Pose(behind, Eigen::Vector3d::Zero())));
}

TEST_F(DepthComparisonTest, NoiseAndASmallErrorOfThePoseContradictNothing) {
  int i = 0;
  const cv::Mat noisy = View([&](const Eigen::Vector3d&) { return ++i % 2 == 0 ? 2.98 : 3.02; });
  EXPECT_EQ(Contradiction(noisy, Box(-0.2, 0.2), Pose::FromTangent({0.03, 0, 0.02}, {0, 0.005, 0})),
            0.0);
}

}  // namespace
}  // namespace highwall::depth_agreement_test
