#include <highwall/frontend/features/twist.h>

#include <random>

#include <gtest/gtest.h>

namespace highwall::twist_test {
namespace {

Eigen::Vector3d Draw(std::mt19937& rng) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return {uniform(rng), uniform(rng), uniform(rng)};
}

// Points are a few metres away; rounding is 1e-15 of that in a handful of operations.
constexpr double kTolerance = 2e-14;

TEST(Twist, TransformsAPointAsItsPoseDoes) {
  std::mt19937 rng(1);
  // Angles [rad] of none, of rows, on both sides of the limit of the series, and large ones.
  for (const double angle : {0.0, 1e-9, 1e-3, 0.0999999, 0.1000001, 0.5, 3.0}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d axis = Draw(rng).normalized(), p = 3.0 * Draw(rng);
      const double dt = 0.04;
      const Twist motion{Draw(rng) / dt, angle / dt * axis};
      EXPECT_LT((motion.Transform(dt, p) - motion.Over(dt) * p).norm(), kTolerance) << angle;
      EXPECT_LT((motion.Transform(-dt, p) - motion.Over(dt).Inverse() * p).norm(), kTolerance)
          << angle;
    }
  }
}

TEST(Twist, BetweenTwoPosesLeadsFromOneToTheOther) {
  std::mt19937 rng(2);
  const Twist motion{Draw(rng), Draw(rng)};
  const Twist found = Twist::Between(motion.Over(0.7), 0.7);
  EXPECT_LT((found.v - motion.v).norm(), 1e-14);
  EXPECT_LT((found.omega - motion.omega).norm(), 1e-14);
}

}  // namespace
}  // namespace highwall::twist_test
