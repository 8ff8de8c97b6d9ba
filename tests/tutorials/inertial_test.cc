// The program of docs/tutorial_inertial.md.
#include "examples/inertial/inertial_trajectory.h"

#include <random>

#include <gtest/gtest.h>

#include "support/imu_scene.h"

namespace highwall {
namespace {

constexpr double kHertz = 200.0, kImages = 10.0;

class InertialTutorial : public ::testing::Test {
 protected:
  InertialTutorial() {
    std::uniform_real_distribution<double> uniform(-6.0, 6.0);
    for (int i = 0; i < 4000; ++i) {
      const double x = uniform(rng_), y = uniform(rng_), z = uniform(rng_);
      points_.push_back({x, y, z});
    }
  }

  double Noise(double sigma) { return std::normal_distribution<double>(0.0, sigma)(rng_); }
  Eigen::Vector3d Noise3(double sigma) {
    const double x = Noise(sigma), y = Noise(sigma), z = Noise(sigma);
    return {x, y, z};
  }

  // Feeds the readings from one time to another [s].
  void Read(InertialTrajectory& trajectory, double from, double to) {
    for (auto i = std::lround(from * kHertz); i < std::lround(to * kHertz); ++i) {
      ImuSample reading = motion_.SampleAt(FromSeconds(static_cast<double>(i) / kHertz));
      reading.gyroscope += bias_.head<3>() + Noise3(noise_.gyroscope * std::sqrt(kHertz));
      reading.accelerometer += bias_.tail<3>() + Noise3(noise_.accelerometer * std::sqrt(kHertz));
      trajectory.AddReading(reading);
    }
  }
  // Returns about 40 features of an image, with the noise assumed by the program.
  std::vector<Feature> See(double t) {
    const Pose T_CW = (motion_.StateAt(t).T_WB * T_BC_).Inverse();
    std::vector<Feature> features;
    for (std::size_t i = 0; i < points_.size() && features.size() < 40; ++i) {
      const Eigen::Vector3d p_C = T_CW * points_[i];
      if (p_C.z() < 1.0 || p_C.z() > 5.0 || !camera_.Contains(camera_.Project(p_C), 0.0)) continue;
      const Eigen::Vector2d uv = camera_.Project(p_C) + Noise3(1.0).head<2>();
      features.push_back({static_cast<int>(i), uv, p_C.z() + Noise(DepthNoise().Sigma(p_C.z()))});
    }
    return features;
  }

  const SinusoidalMotion motion_;
  const PinholeCamera camera_;
  const Pose T_BC_ = Pose::FromTangent({0.05, -0.02, 0.1}, {-1.2, 1.2, -1.2});
  const ImuNoise noise_{.gyroscope = 2e-4, .accelerometer = 2e-3};
  const ImuBias bias_ = (ImuBias() << 0.005, -0.004, 0.006, 0.05, -0.03, 0.04).finished();
  std::mt19937 rng_{5};
  std::vector<Eigen::Vector3d> points_;
};

TEST_F(InertialTutorial, FollowsTheBodyAndFindsTheBiases) {
  ImuState start = motion_.StateAt(0.0);
  start.v_WB += Eigen::Vector3d(0.03, -0.03, 0.03);
  InertialTrajectory trajectory(camera_, T_BC_, noise_, start);
  for (int k = 0; k <= 50; ++k) {
    const double t = k / kImages;
    Read(trajectory, k == 0 ? 0.0 : t - 1.0 / kImages + 0.02, t + 0.02);
    const std::optional<Pose> T_WB = trajectory.AddImage(FromSeconds(t), See(t));
    ASSERT_TRUE(T_WB) << k;
    // A pixel is 5 mm at 2.5 m, and 40 features give 1 mm. 5 s of odometry drift by some
    // millimetres.
    EXPECT_LT((T_WB->p() - motion_.StateAt(t).T_WB.p()).norm(), 0.03) << k;
    EXPECT_LT((T_WB->Inverse() * motion_.StateAt(t).T_WB).Angle(), 0.01) << k;
  }
  EXPECT_LT((trajectory.state().v_WB - motion_.StateAt(5.0).v_WB).norm(), 0.03);
  EXPECT_LT((trajectory.bias() - bias_).head<3>().norm(), 2e-3);
  EXPECT_LT((trajectory.bias() - bias_).tail<3>().norm(), 0.06);
}

TEST_F(InertialTutorial, ContinuesWithoutFeaturesForASecond) {
  InertialTrajectory trajectory(camera_, T_BC_, noise_, motion_.StateAt(0.0));
  for (int k = 0; k <= 50; ++k) {
    const double t = k / kImages;
    Read(trajectory, k == 0 ? 0.0 : t - 1.0 / kImages + 0.02, t + 0.02);
    const bool dark = k > 30 && k <= 40;
    const auto T_WB = trajectory.AddImage(FromSeconds(t), dark ? std::vector<Feature>() : See(t));
    ASSERT_TRUE(T_WB) << k;
    EXPECT_LT((T_WB->p() - motion_.StateAt(t).T_WB.p()).norm(), 0.06) << k;
  }
}

TEST_F(InertialTutorial, SaysWhereReadingsAreMissing) {
  InertialTrajectory trajectory(camera_, T_BC_, noise_, motion_.StateAt(0.0));
  Read(trajectory, 0.0, 0.15);
  EXPECT_TRUE(trajectory.AddImage(0, See(0.0)));
  EXPECT_FALSE(trajectory.AddImage(FromSeconds(0.2), See(0.2)));
  EXPECT_TRUE(trajectory.AddImage(FromSeconds(0.1), See(0.1))) << "and continues";
}

}  // namespace
}  // namespace highwall
