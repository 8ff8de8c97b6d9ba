#include <highwall/factors/zero_velocity.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/imu_scene.h"
#include "support/imu_twins.h"

namespace highwall::zero_velocity_test {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

// 0.5 s at rest, at 200 Hz, with noise of the options' sigmas and a bias.
std::vector<ImuSample> AtRest(unsigned seed, const StationaryOptions& options = {}) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 100; ++i) {
    ImuSample sample{i * 5'000'000, {0.02, -0.03, 0.01}, {0.1, -0.2, 9.81}};
    for (int k = 0; k < 3; ++k) {
      sample.gyroscope(k) += options.gyroscope_sigma * normal(rng);
      sample.accelerometer(k) += options.accelerometer_sigma * normal(rng);
    }
    samples.push_back(sample);
  }
  return samples;
}

TEST(ZeroVelocity, IsTheVelocityInSigmas) {
  const ZeroVelocity f(0.02);
  EXPECT_EQ(Residual(f, {{0, 0, 0}}).norm(), 0.0);
  EXPECT_LT((Residual(f, {{0.1, -0.2, 0.04}}) - Eigen::Vector3d(5, -10, 2)).norm(), 1e-13);
}

TEST(ZeroVelocity, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(70);
  for (int i = 0; i < 50; ++i) {
    const ZeroVelocity f(Uniform(rng, 0.1, 1.0));
    const std::vector<Block> blocks = {ToBlock(RandomVector(rng, 3.0))};
    const auto check = testing::CheckJacobians(f, blocks, {nullptr});
    EXPECT_TRUE(check) << check.message;
  }
  ExpectTwins(ZeroVelocity(0.3), *twins::MakeZeroVelocity(0.3), {{0.1, 2.0, -1.0}}, {nullptr},
              1e-14);
}

TEST(ZeroVelocity, KeepsItsLengthWhenTheWorldTurns) {
  const ZeroVelocity f(0.02);
  const Eigen::Vector3d v(0.1, -0.2, 0.04), turned = so3::Exp({0.3, -0.5, 1.0}) * v;
  EXPECT_NEAR(Residual(f, {ToBlock(v)}).norm(), Residual(f, {ToBlock(turned)}).norm(), 1e-12);
}

TEST(ZeroVelocity, PullsAVelocityToRest) {
  FactorGraph graph;
  const auto v = graph.AddVariable(Eigen::Vector3d(1, 2, 3));
  graph.AddFactor(std::make_unique<ZeroVelocity>(0.01), v);
  graph.AddFactor(
      std::make_unique<VectorPrior<3>>(Eigen::Vector3d(1, 0, 0), Eigen::Matrix3d::Identity()), v);
  SolveOptions options;
  options.function_tolerance = 1e-20;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  // Fused by information: 1 / (1 + 1e4).
  EXPECT_LT((graph.Value(v) - Eigen::Vector3d(1.0 / 10001.0, 0, 0)).norm(), 1e-9);
}

TEST(Stationary, StatisticOfNoiseAtRestIsOneWhateverTheBias) {
  double mean = 0.0;
  for (unsigned seed = 0; seed < 50; ++seed) mean += StationaryStatistic(AtRest(seed)) / 50.0;
  // 50 x 600 squares: standard error 0.8 %.
  EXPECT_NEAR(mean, 1.0, 0.03);
  for (unsigned seed = 0; seed < 50; ++seed) EXPECT_TRUE(IsStationary(AtRest(seed)));
}

TEST(Stationary, SeesMotionAndVibration) {
  EXPECT_FALSE(IsStationary(SinusoidalMotion().Samples(200.0, 0.5)));
  auto vibrating = AtRest(1);
  for (std::size_t i = 0; i < vibrating.size(); ++i) {
    vibrating[i].accelerometer.z() += i % 2 == 0 ? 0.5 : -0.5;
  }
  EXPECT_FALSE(IsStationary(vibrating));
  auto turning = AtRest(2);
  for (ImuSample& sample : turning) sample.gyroscope.z() += 0.2;  // constant rate: no variance
  EXPECT_LT(StationaryStatistic(turning), 1.5);
  EXPECT_FALSE(IsStationary(turning));
}

TEST(Stationary, NeverSpeaksOfShortOrBrokenWindows) {
  const auto samples = AtRest(3);
  const std::span<const ImuSample> all = samples;
  EXPECT_FALSE(IsStationary(all.first(0)));
  EXPECT_FALSE(IsStationary(all.first(1)));
  EXPECT_FALSE(IsStationary(all.first(40)));  // 0.195 s
  EXPECT_TRUE(IsStationary(all.first(41)));
  auto broken = samples;
  broken[7].gyroscope.x() = kNan;
  EXPECT_FALSE(IsStationary(broken));
}

TEST(ZeroVelocity, RefusesBadArguments) {
  EXPECT_THROW(ZeroVelocity(0.0), InvalidArgument);
  EXPECT_THROW(ZeroVelocity{kNan}, InvalidArgument);
  const auto samples = AtRest(4);
  EXPECT_THROW(StationaryStatistic(std::span<const ImuSample>(samples).first(1)), InvalidArgument);
  EXPECT_THROW(IsStationary(samples, {.gyroscope_sigma = 0.0}), InvalidArgument);
  EXPECT_THROW(IsStationary(samples, {.max_statistic = kNan}), InvalidArgument);
  EXPECT_THROW(IsStationary(samples, {.min_duration = -1.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::zero_velocity_test
