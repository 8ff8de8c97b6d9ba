#include <highwall/frontend/calibration/depth_scale.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/factors/imu_preintegration.h>

#include "inertial_scene.h"
#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::depth_scale_test {
namespace {

using testing::InertialScene;
using testing::InertialSceneOptions;
using testing::operator""_kf;

constexpr double kTooLong = 1.04;  // measured depth of a true metre
constexpr double kInterval = 0.5;  // [s] from a keyframe to the next
const DepthScaleOptions kOptions;

// Returns the map of a moving body with an IMU: the keyframes' relative poses have the noise that
// the estimator assumes, and their lengths are `depth` times the true ones.
Map MakeMap(const InertialSceneOptions& options, double depth, int keyframes,
            double position_share = kOptions.position_share) {
  InertialScene scene(options);
  const auto camera = [&](double t) {
    const Pose T_WC = scene.T_WC(t);
    return Pose(T_WC.q(), depth * T_WC.p());
  };
  Map map;
  const auto features = std::make_shared<const FrameFeatures>();
  Pose T_WC = camera(0.0);
  for (int k = 0; k < keyframes; ++k) {
    const double t = kInterval * k;
    if (k > 0) {
      const Pose motion = camera(t - kInterval).Inverse() * camera(t);
      const double sigma = kOptions.position_sigma + position_share * motion.p().norm();
      Eigen::Matrix<double, 6, 1> noise;
      noise << scene.Noise(sigma), scene.Noise(kOptions.rotation_sigma);
      T_WC = T_WC * motion.Plus(noise);
    }
    KeyFrame& keyframe = map.AddKeyFrame({k, FromSeconds(t), features}, T_WC);
    InertialState& at = keyframe.motion.emplace();
    at.stamp = FromSeconds(t);
    at.v_WB = scene.StateAt(t).v_WB;
    if (k == 0) continue;
    at.previous = KeyFrameId(keyframe.id.value() - 1);
    at.from_previous =
        std::make_shared<const ImuPreintegration>(scene.Readings(t - kInterval, t), ImuBias::Zero(),
                                                  ImuPreintegrationOptions{.noise = options.noise});
  }
  map.SetGravity(scene.gravity_W());
  return map;
}

TEST(DepthScale, FindsADepthThatReadsTooLong) {
  const Map map = MakeMap({}, kTooLong, 40);
  const auto depth = EstimateDepthScale(map, InertialScene::T_BC());
  ASSERT_TRUE(depth);
  EXPECT_EQ(depth->keyframes, 40);
  EXPECT_LT(depth->sigma, 0.005);
  EXPECT_NEAR(depth->scale, 1.0 / kTooLong, 3.0 * depth->sigma);
}

TEST(DepthScale, IsConsistentOverThirtySeeds) {
  constexpr int kRuns = 30;
  double nees = 0.0, error = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const InertialSceneOptions options{
        .motion = 0.5,
        .bias = (ImuBias() << 0.01, 0, -0.01, 0.05, -0.05, 0).finished(),
        .seed = seed};
    const auto depth = EstimateDepthScale(MakeMap(options, kTooLong, 20), InertialScene::T_BC());
    ASSERT_TRUE(depth) << seed;
    nees += std::pow((depth->scale - 1.0 / kTooLong) / depth->sigma, 2) / kRuns;
    error += depth->error / kRuns;
  }
  // Chi-squared of one: 1 +- sqrt(2 / N); of 6 x 19 - 5: 1 +- sqrt(2 / 109 N).
  EXPECT_NEAR(nees, 1.0, 4.0 * std::sqrt(2.0 / kRuns));
  EXPECT_NEAR(error, 1.0, 4.0 * std::sqrt(2.0 / (109.0 * kRuns)));
}

TEST(DepthScale, KnowsNothingOfABodyAtRest) {
  const auto depth =
      EstimateDepthScale(MakeMap({.motion = 0.0}, kTooLong, 40), InertialScene::T_BC());
  ASSERT_TRUE(depth);
  EXPECT_NEAR(depth->scale, 1.0, 3.0 * kOptions.prior_sigma);
  EXPECT_GT(depth->sigma, 0.8 * kOptions.prior_sigma);
}

TEST(DepthScale, WorseMotionsThanReckonedWithWidenSigma) {
  const auto good = EstimateDepthScale(MakeMap({}, 1.0, 40), InertialScene::T_BC());
  const auto bad = EstimateDepthScale(MakeMap({}, 1.0, 40, 0.05), InertialScene::T_BC());
  ASSERT_TRUE(good && bad);
  EXPECT_GT(bad->error, 4.0);
  EXPECT_GT(bad->sigma, 2.0 * good->sigma);
  EXPECT_NEAR(bad->scale, 1.0, 3.0 * bad->sigma);
}

TEST(DepthScale, JoinsTheRunsOfAnInterruptedImu) {
  Map map = MakeMap({}, kTooLong, 40);
  InertialState& broken = *map.keyframe(15_kf)->motion;
  broken.previous = kNoId;
  broken.from_previous = nullptr;
  // The drift of the images in the meantime does not matter.
  const Pose drift = Pose::FromTangent({1.0, 2.0, 0.5}, {0.02, -0.03, 0.5});
  for (KeyFrameId id = 15_kf; id < 40_kf; ++id) {
    map.keyframe(id)->T_WC = drift * map.keyframe(id)->T_WC;
  }
  const auto depth = EstimateDepthScale(map, InertialScene::T_BC());
  ASSERT_TRUE(depth);
  EXPECT_EQ(depth->keyframes, 40);
  EXPECT_LT(depth->sigma, 0.005);
  EXPECT_NEAR(depth->scale, 1.0 / kTooLong, 3.0 * depth->sigma);
}

TEST(DepthScale, IsEmptyWithoutThreeKeyFramesInARow) {
  EXPECT_FALSE(EstimateDepthScale(Map(), Pose()));
  EXPECT_FALSE(EstimateDepthScale(MakeMap({}, 1.0, 2), InertialScene::T_BC()));
  EXPECT_TRUE(EstimateDepthScale(MakeMap({}, 1.0, 3), InertialScene::T_BC()));
  Map levelless = MakeMap({}, 1.0, 3);
  levelless.SetGravity(std::nullopt);
  EXPECT_FALSE(EstimateDepthScale(levelless, InertialScene::T_BC()));
}

TEST(DepthScale, IsEmptyWhereReadingsCannotBeSolvedFor) {
  for (const double spike : {3e7, 1e9, 1e150}) {
    Map map = MakeMap({}, 1.0, 6);
    InertialScene scene;
    std::vector<ImuSample> readings = scene.Readings(2.5 * kInterval, 3.0 * kInterval);
    readings[10].accelerometer.x() = spike;
    readings.front().stamp = map.keyframe(2_kf)->motion->stamp;
    map.keyframe(3_kf)->motion->from_previous =
        std::make_shared<const ImuPreintegration>(readings, ImuBias::Zero());
    std::optional<DepthScale> scale;
    EXPECT_NO_THROW(scale = EstimateDepthScale(map, InertialScene::T_BC())) << spike;
    EXPECT_FALSE(scale && !(std::isfinite(scale->scale) && std::isfinite(scale->sigma))) << spike;
  }
}

TEST(DepthScale, TheMapWithoutTheImuIsThatOfItsImages) {
  // The IMU has shrunk the keyframe positions by 4 %, but not the scene.
  const testing::Scene scene = testing::MakeScene(9, 120, 30);
  testing::SceneMap scene_map(scene);
  for (int k = 0; k < 4; ++k) {
    const Pose T_WC = Pose::FromTangent({0.2 * k, 0.1 * (k % 2), 0}, {0, -0.02 * k, 0});
    scene_map.Add(testing::Look(scene, testing::IdealSensor(), T_WC), T_WC);
  }
  Map& map = scene_map.map;
  map.SetGravity(Eigen::Vector3d(0, 0, -9.81));
  for (const KeyFrameId id : map.keyframe_ids()) {
    const Pose& T_WC = map.keyframe(id)->T_WC;
    map.keyframe(id)->T_WC = Pose(T_WC.q(), 0.96 * T_WC.p());
  }
  const Map images = AdjustedWithoutImu(map, {testing::IdealSensor(), {}});
  EXPECT_EQ(images.gravity_W(), map.gravity_W());
  EXPECT_NEAR(images.keyframe(3_kf)->T_WC.p().x(), 0.6, 1e-3);
  EXPECT_NEAR(map.keyframe(3_kf)->T_WC.p().x(), 0.96 * 0.6, 1e-12) << "the map is as it was";
}

TEST(DepthScale, RefusesOptionsByName) {
  const auto refuses = [](const DepthScaleOptions& options, const std::string& field) {
    try {
      options.Validate();
    } catch (const InvalidArgument& error) {
      return std::string(error.what()).find(field) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refuses({.prior_sigma = 0.0}, "prior_sigma"));
  EXPECT_TRUE(refuses({.position_sigma = NAN}, "position_sigma"));
  EXPECT_TRUE(refuses({.position_share = -1.0}, "position_share"));
  EXPECT_TRUE(refuses({.rotation_sigma = -1.0}, "rotation_sigma"));
  EXPECT_TRUE(refuses({.gyroscope_bias_sigma = 0.0}, "gyroscope_bias_sigma"));
  EXPECT_TRUE(refuses({.accelerometer_bias_sigma = INFINITY}, "accelerometer_bias_sigma"));
  EXPECT_NO_THROW((DepthScaleOptions{.position_share = 0.0}.Validate()));
}

}  // namespace
}  // namespace highwall::depth_scale_test
