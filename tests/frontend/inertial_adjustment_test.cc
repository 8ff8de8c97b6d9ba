#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/factors/imu_factor.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/local/bundle_adjustment.h>

#include "inertial_scene.h"
#include "loops/loop_closer.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"
#include "support/synthetic_scene.h"

// The IMU in adjustments: around a keyframe, of a whole map, and after a loop.
namespace highwall::inertial_adjustment_test {
namespace {

using testing::AngleBetween;
using testing::AngleError;
using testing::IdealSensor;
using testing::InertialScene;
using testing::Look;
using testing::LoopScene;
using testing::LoopSceneOptions;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::UniformInBox;
using testing::operator""_kf;

// Returns the motion of a keyframe with an IMU factor to the previous one.
InertialState ConstrainedState(const ImuState& state, const std::vector<ImuSample>& readings,
                               const ImuNoise& noise, KeyFrameId previous) {
  InertialState motion;
  motion.stamp = readings.back().stamp;
  motion.v_WB = state.v_WB;
  motion.previous = previous;
  motion.from_previous = std::make_shared<const ImuPreintegration>(
      readings, ImuBias::Zero(), ImuPreintegrationOptions{.noise = noise});
  return motion;
}

TEST(InertialAdjustment, HasTheCostOfAnImuFactorComputedByHand) {
  // The body is at rest for a second, and the map has it 1 cm higher at the end. Along gravity,
  // rotations and constant biases do not count to first order: with white noise s of the
  // acceleration, velocity and position have the covariance s^2 [T T^2/2; T^2/2 T^3/3], whose
  // inverse has 12 / (s^2 T^3) for the position.
  constexpr double kSigma = 0.02, kHeight = 0.01, kSeconds = 1.0, kWeight = 0.5;
  const ImuNoise noise{.gyroscope = 1e-6,
                       .accelerometer = kSigma,
                       .gyroscope_walk = 1e-9,
                       .accelerometer_walk = 1e-9};
  std::vector<ImuSample> readings;
  for (int i = 0; i <= 1000; ++i) {
    readings.push_back({FromSeconds(kSeconds * i / 1000), {0, 0, 0}, {0, 0, kStandardGravity}});
  }
  Map map;
  const auto features = std::make_shared<const FrameFeatures>();
  for (int k = 0; k < 2; ++k) {
    map.AddKeyFrame({k, FromSeconds(kSeconds * k), features},
                    Pose(Eigen::Quaterniond::Identity(), {0, 0, kHeight * k}));
  }
  map.keyframe(0_kf)->motion.emplace();
  map.keyframe(1_kf)->motion = ConstrainedState({}, readings, noise, 0_kf);
  map.keyframe(1_kf)->motion->weight = kWeight;
  map.SetGravity(kGravity);
  const MeasurementModel model(IdealSensor(), {});
  const std::vector<KeyFrameId> first{0_kf}, second{1_kf};
  const auto report = AdjustBundle(map, model, second, first);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.imu_factors, 1);
  const double cost =
      0.5 * kWeight * 12.0 / (kSigma * kSigma * std::pow(kSeconds, 3)) * kHeight * kHeight;
  // The steps are a thousandth of T instead of infinitely small.
  EXPECT_NEAR(report.initial_cost, cost, 2e-3 * cost);
  EXPECT_LT(report.final_cost, 1e-9 * cost);  // the free velocities absorb the error
}

// A body in motion among points on all sides, with keyframes every 0.4 s and readings without noise
// but with a bias that the map does not know.
class DisturbedWalk : public ::testing::Test {
 protected:
  static constexpr int kKeyFrames = 12;
  static constexpr double kInterval = 0.4;

  DisturbedWalk() : scene_map(scene) {
    const SinusoidalMotion motion;
    const ImuNoise noise;
    for (int k = 0; k < kKeyFrames; ++k) {
      const Pose T_WC = Truth(k).T_WB * InertialScene::T_BC();
      const KeyFrameId id = scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
      if (k == 0) {
        map.keyframe(id)->motion.emplace().v_WB = Truth(0).v_WB;
        continue;
      }
      std::vector<ImuSample> readings;
      for (int i = 0; i <= 200; ++i) {
        readings.push_back(motion.SampleAt(FromSeconds(kInterval * (k - 1 + i / 200.0))));
      }
      map.keyframe(id)->motion =
          ConstrainedState(Truth(k), WithBias(readings, kBias), noise, KeyFrameId(k - 1));
    }
    Disturb();
  }

  static Scene MakeSurroundings() {
    std::mt19937 rng(4);
    Scene scene;
    while (scene.points.size() < 3000) {
      const Eigen::Vector3d p_W = UniformInBox(rng, {-7, -7, -5}, {7, 7, 5});
      if (p_W.norm() < 4.0) continue;
      scene.points.push_back({p_W, testing::RandomDescriptor(rng), testing::Uniform(rng, 3, 9)});
    }
    return scene;
  }
  ImuState Truth(int k) const { return SinusoidalMotion().StateAt(kInterval * k); }

  // Perturbs all poses but the first by 1 cm and 0.3 deg, velocities by 0.1 m/s, gravity by 0.6
  // deg.
  void Disturb() {
    std::mt19937 rng(8);
    const auto step = [&](double size) -> Eigen::Vector3d {
      return UniformInBox(rng, {-size, -size, -size}, {size, size, size});
    };
    for (const KeyFrameId id : map.keyframe_ids()) {
      KeyFrame& keyframe = *map.keyframe(id);
      keyframe.motion->v_WB += step(0.1);
      Eigen::Matrix<double, 6, 1> d;
      d << step(0.01), step(0.005);
      if (id != 0_kf) keyframe.T_WC = keyframe.T_WC.Plus(d);
    }
    map.SetGravity(so3::Exp({0.008, -0.006, 0.0}) * kGravity);
  }

  void ExpectTruth(int first) const {
    for (int k = first; k < kKeyFrames; ++k) {
      const KeyFrame& keyframe = *map.keyframe(KeyFrameId(k));
      EXPECT_LT(PositionError(keyframe.T_WC, Truth(k).T_WB * InertialScene::T_BC()), 1e-4) << k;
      EXPECT_LT(AngleError(keyframe.T_WC, Truth(k).T_WB * InertialScene::T_BC()), 1e-4) << k;
      // The priors on gravity (0.02 rad, around a perturbed one) and on the bias (1, around zero)
      // cause this error.
      EXPECT_LT((keyframe.motion->v_WB - Truth(k).v_WB).norm(), 2e-3) << k;
      EXPECT_LT((keyframe.motion->bias - kBias).head<3>().norm(), 2e-4) << k;
      EXPECT_LT((keyframe.motion->bias - kBias).tail<3>().norm(), 1e-2) << k;
    }
  }

  const ImuBias kBias = (ImuBias() << 0.01, -0.02, 0.015, 0.1, -0.05, 0.08).finished();
  const MeasurementModel model{IdealSensor(), {}, InertialScene::T_BC()};
  const Scene scene = MakeSurroundings();
  SceneMap scene_map;
  Map& map = scene_map.map;
  const BundleAdjustmentOptions thorough{.first_iterations = 30, .second_iterations = 30};
};

TEST_F(DisturbedWalk, AnAdjustmentOfAllFindsVelocitiesBiasesAndGravityAndTheMapKeepsThem) {
  const auto report = AdjustBundle(map, model, map.keyframe_ids(), {}, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.imu_factors, kKeyFrames - 1);
  ExpectTruth(0);
  EXPECT_NEAR(map.gravity_W()->norm(), kStandardGravity, 1e-9);
  EXPECT_LT(AngleBetween(*map.gravity_W(), kGravity), 1e-3);
}

TEST_F(DisturbedWalk, AnAdjustmentFindsTheOffsetWithWhichReadingsWereTakenAtImages) {
  // The offset is 0, but was estimated as 6 ms at the first keyframe, and as less with each.
  const auto offset = [](int k) { return 0.006 * (1.0 - k / (kKeyFrames - 1.0)); };
  const auto read_at = [&](int k) { return FromSeconds(kInterval * k + offset(k)); };
  for (int k = 0; k < kKeyFrames; ++k) {
    KeyFrame& keyframe = *map.keyframe(KeyFrameId(k));
    keyframe.frame.stamp = FromSeconds(kInterval * k);
    keyframe.motion->stamp = read_at(k);
    keyframe.motion->v_WB = Truth(k).v_WB;
    keyframe.motion->time_offset_sigma = 0.006;
    if (k == 0) continue;
    const Stamp from = read_at(k - 1), step = (read_at(k) - from) / 200;
    std::vector<ImuSample> readings;
    for (int i = 0; i < 200; ++i) readings.push_back(SinusoidalMotion().SampleAt(from + i * step));
    readings.push_back(SinusoidalMotion().SampleAt(read_at(k)));
    keyframe.motion->from_previous = std::make_shared<const ImuPreintegration>(
        WithBias(readings, kBias), ImuBias::Zero(), ImuPreintegrationOptions());
  }
  ASSERT_TRUE(AdjustBundle(map, model, map.keyframe_ids(), {}, thorough).usable);
  for (int k = 0; k < kKeyFrames; ++k) {
    // The poses move at constant velocities: half of 4 m/s^2 over (6 ms)^2 is 0.07 mm at each end
    // of the first readings. Without the offset the errors are 10 to 30 mm.
    const Pose& T_WC = map.keyframe(KeyFrameId(k))->T_WC;
    EXPECT_LT(PositionError(T_WC, Truth(k).T_WB * InertialScene::T_BC()), 4e-4) << k;
    EXPECT_LT(AngleError(T_WC, Truth(k).T_WB * InertialScene::T_BC()), 2e-4) << k;
  }
}

TEST_F(DisturbedWalk, AnAdjustmentAroundAKeyFrameKeepsAllButGravity) {
  // Half of the path is at its true poses, and held fixed.
  std::vector<KeyFrameId> fixed, free;
  for (int k = 0; k < kKeyFrames; ++k) {
    (k < 6 ? fixed : free).push_back(KeyFrameId(k));
    if (k < 6) map.keyframe(KeyFrameId(k))->T_WC = Truth(k).T_WB * InertialScene::T_BC();
  }
  const Eigen::Vector3d gravity_W = *map.gravity_W();
  const auto report = AdjustBundle(map, model, free, fixed, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.imu_factors, kKeyFrames - 1);
  ExpectTruth(6);
  EXPECT_EQ(*map.gravity_W(), gravity_W);
}

// A loop at constant speed: the readings are constant too, and exact.
class InertialLoop : public LoopScene {
 public:
  static constexpr double kInterval = 0.5;  // [s] from a keyframe to the next

  InertialLoop() : LoopScene({.drift = {0.01, 0.005, 0.0}}) {}

  KeyFrameId AddWithMotion(int i) {
    const KeyFrameId id = Add(i);
    KeyFrame& keyframe = *map.keyframe(id);
    const Pose T_W_true = keyframe.T_WC * truth.back().Inverse();
    if (i == 0) {
      keyframe.motion.emplace().v_WB = TrueVelocity(0);
      map.SetGravity(so3::Exp({0.008, -0.006, 0.0}) * kGravity);
      return id;
    }
    const double rate = 2.0 * M_PI / 48.0 / kInterval;  // [rad/s] about z of W
    std::vector<ImuSample> readings;
    for (int k = 0; k <= 100; ++k) {
      const double s = i - 1 + k / 100.0;
      const Eigen::Vector3d outwards = Outwards(s);
      const Eigen::Quaterniond q_BW = RotationAt(s).conjugate();
      readings.push_back({FromSeconds(kInterval * s), q_BW * Eigen::Vector3d(0, 0, rate),
                          q_BW * Eigen::Vector3d(-2.0 * rate * rate * outwards - kGravity)});
    }
    const ImuState state{keyframe.T_WC, T_W_true.q() * TrueVelocity(i)};
    keyframe.motion =
        ConstrainedState(state, WithBias(readings, kBias), ImuNoise{}, KeyFrameId(i - 1));
    return id;
  }

  Eigen::Vector3d TrueVelocity(int i) const {
    const double rate = 2.0 * M_PI / 48.0 / kInterval;
    return 2.0 * rate * Eigen::Vector3d::UnitZ().cross(Outwards(i));
  }

  const ImuBias kBias = (ImuBias() << 0.002, -0.001, 0.003, 0.03, -0.02, 0.02).finished();

 private:
  static Eigen::Vector3d Outwards(double s) {
    const double azimuth = 2.0 * M_PI * s / 48.0;
    return {std::cos(azimuth), std::sin(azimuth), 0.0};
  }
  Eigen::Quaterniond RotationAt(double s) const {
    return so3::Exp({0.0, 0.0, 2.0 * M_PI * s / 48.0}) * TruePose(0).q();
  }
};

TEST(LoopWithAnImu, LeavesTheMapWithTheVelocitiesBiasesAndGravityOfItsAdjustment) {
  InertialLoop scene;
  LoopCloser closer(scene.model, {}, 0);
  KeyFrameId last = kNoId;  // at the time of the loop adjustment
  for (int i = 0; i < scene.size() && last == kNoId; ++i) {
    const KeyFrameId id = scene.AddWithMotion(i);
    closer.InsertKeyFrame(scene.map, id);
    for (const LoopReport& report : closer.Update(&scene.map)) {
      ASSERT_TRUE(report.accepted) << report.message;
      if (!report.bundle) continue;
      ASSERT_TRUE(report.bundle->usable);
      EXPECT_GT(report.bundle->imu_factors, 40);
      last = id;
    }
  }
  ASSERT_NE(last, kNoId);
  // The error is relative to the exact truth, with pixels off by 0.7 and depth as it is. The drift
  // was 1.1 cm a keyframe.
  EXPECT_LT(scene.Rmse(), 0.02);
  EXPECT_LT(AngleBetween(*scene.map.gravity_W(), kGravity), 2e-3);
  for (const KeyFrameId id : scene.map.keyframe_ids()) {
    const InertialState& motion = *scene.map.keyframe(id)->motion;
    EXPECT_LT((motion.v_WB - scene.TrueVelocity(id.value())).norm(), 0.01) << id;
    EXPECT_LT((motion.bias - scene.kBias).head<3>().norm(), 1e-3) << id;
    EXPECT_LT((motion.bias - scene.kBias).tail<3>().norm(), 0.03) << id;
  }
}

}  // namespace
}  // namespace highwall::inertial_adjustment_test
