// The program of docs/tutorial_odometry.md.
#include "examples/odometry/odometry.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace highwall {
namespace {

class OdometryTutorial : public ::testing::Test {
 protected:
  OdometryTutorial() {
    std::uniform_real_distribution<double> x(-4.0, 4.0), y(-2.0, 2.0), z(2.0, 6.0);
    for (int i = 0; i < 400; ++i) {
      const double u = x(rng_), v = y(rng_), w = z(rng_);
      points_.push_back({u, v, w});
    }
  }
  // The camera moves sideways and turns to and fro.
  static Pose At(int k) {
    return Pose::FromTangent({0.02 * k, 0.05 * std::sin(0.2 * k), 0.01 * k},
                             {0.0, 0.1 * std::sin(0.1 * k), 0.02 * std::sin(0.3 * k)});
  }
  // Returns the visible points with the noise of the sensor; every tenth is a wrong match.
  std::vector<TrackedPoint> See(int k, bool with_depth = true) {
    const PinholeCamera& camera = sensor_.camera;
    const Pose T_CW = (At(0).Inverse() * At(k)).Inverse();
    std::vector<TrackedPoint> seen;
    std::normal_distribution<double> noise;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p_C = T_CW * points_[i];
      if (p_C.z() < 0.5 || !camera.Contains(camera.Project(p_C), 2.0)) continue;
      PointFeature feature;
      const double u = 0.5 * noise(rng_), v = 0.5 * noise(rng_);
      feature.uv = camera.Project(p_C) + Eigen::Vector2d(u, v);
      feature.depth =
          with_depth ? p_C.z() + DepthNoise(sensor_.depth_noise).Sigma(p_C.z()) * noise(rng_) : 0.0;
      if (k > 0 && i % 10 == 0) feature.uv += 40.0 * Eigen::Vector2d(noise(rng_), noise(rng_));
      seen.push_back({static_cast<int>(i), feature});
    }
    return seen;
  }

  const RgbdSensor sensor_;
  std::mt19937 rng_{7};
  std::vector<Eigen::Vector3d> points_;
};

TEST_F(OdometryTutorial, FollowsTheCameraThroughWrongMatches) {
  Odometry odometry(sensor_);
  for (int k = 0; k < 60; ++k) {
    const std::optional<Pose> T_WC = odometry.AddImage(FromSeconds(k / 15.0), See(k));
    ASSERT_TRUE(T_WC) << k;
    const Pose error = T_WC->Inverse() * (At(0).Inverse() * At(k));
    // Odometry drifts: by 16 mm at most over 1.2 m, and 11 mm without wrong matches.
    EXPECT_LT(error.p().norm(), 0.02) << k;
    EXPECT_LT(error.Angle(), 0.005) << k;
  }
}

TEST_F(OdometryTutorial, TooFewPointsGiveNoPose) {
  Odometry odometry(sensor_);
  ASSERT_TRUE(odometry.AddImage(0, See(0)));
  std::vector<TrackedPoint> few = See(1);
  few.resize(4);
  EXPECT_FALSE(odometry.AddImage(FromSeconds(0.1), few));
  EXPECT_TRUE(odometry.AddImage(FromSeconds(0.2), See(2)));
}

TEST_F(OdometryTutorial, KnownPointsNeedNoDepth) {
  Odometry odometry(sensor_);
  ASSERT_TRUE(odometry.AddImage(0, See(0)));
  const std::optional<Pose> T_WC = odometry.AddImage(FromSeconds(0.1), See(1, false));
  ASSERT_TRUE(T_WC);
  EXPECT_LT((T_WC->Inverse() * (At(0).Inverse() * At(1))).p().norm(), 0.01);
}

}  // namespace
}  // namespace highwall
