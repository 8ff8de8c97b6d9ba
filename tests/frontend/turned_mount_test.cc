#include "sensor/turned_mount.h"

#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

namespace highwall::turned_mount_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kStep = 0.1;    // [s]
constexpr double kSigma = 4e-4;  // [rad] of an image

// Rotations of `count` steps by about `motion` [rad], by images and by a gyroscope with a bias.
// turned [rad]: the true mount from the stated one, which is the identity. only: the axes that the
// camera turns about.
GyroscopeFit Draw(unsigned seed, int count, double motion, const Eigen::Vector3d& turned,
                  const Eigen::Vector3d& only = Eigen::Vector3d::Ones()) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(rng), sigma * normal(rng), sigma * normal(rng));
  };
  const Eigen::Vector3d bias = vector(0.01);
  const Eigen::Matrix3d R_CB = so3::Exp(turned).toRotationMatrix();
  GyroscopeFit fit;
  Eigen::Vector3d before = vector(kSigma);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d body = only.cwiseProduct(vector(motion)), after = vector(kSigma);
    fit.Add(R_CB * body + after - before, body + kStep * bias, kStep);
    before = after;
  }
  return fit;
}

std::optional<TurnedMount> Find(const GyroscopeFit& fit) {
  return FindTurnedMount(std::vector{fit}, Eigen::Matrix3d::Identity());
}

// At a rate of one in a thousand, nine and more alarms in 3000 draws have a probability of 0.4 %.
// The gain of 25 is that of both sensors together.
TEST(FindTurnedMount, GainsOf25AreRarerThanOneInAThousandWithinTheTolerance) {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    const double motion = 2e-4 * std::exp2(0.5 * (seed % 16));  // up to 36 mrad
    const Eigen::Vector3d off =
        so3::Exp(Eigen::Vector3d(0.0, seed, 2.0 * seed)) * Eigen::Vector3d(2.0 * kDegree, 0.0, 0.0);
    const auto found = Find(Draw(seed, 25 + static_cast<int>(seed % 75), motion, off));
    alarms += found && found->gain > 25.0 ? 1 : 0;
  }
  EXPECT_LE(alarms, 8);
}

TEST(FindTurnedMount, FindsARotationOfTenDegrees) {
  const Eigen::Vector3d off = 10.0 * kDegree * Eigen::Vector3d(1.0, 2.0, 3.0).normalized();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto found = Find(Draw(seed, 45, 0.01, off));
    ASSERT_TRUE(found) << seed;
    EXPECT_GT(found->gain, 25.0) << seed;
    // The errors of an image are 4 % of a rotation: over 45 of them, half a degree.
    EXPECT_LT(so3::Log(Eigen::Quaterniond(found->R_CB)).cross(off.normalized()).norm(),
              2.0 * kDegree)
        << seed;
  }
}

// What the images do not show is left as stated: a vehicle turns about one axis.
TEST(FindTurnedMount, LeavesTheAngleAboutTheOnlyAxisThatTurns) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    EXPECT_FALSE(Find(Draw(seed, 60, 0.02, 30.0 * kDegree * z, z))) << seed;
  }
}

TEST(FindTurnedMount, NeedsMoreThanTwoSeconds) {
  EXPECT_FALSE(Find(Draw(1, 24, 0.02, {0.3, 0.0, 0.0})));
  EXPECT_TRUE(Find(Draw(1, 25, 0.02, {0.3, 0.0, 0.0})));
}

// The index is that of the offset of the clocks at which readings and images agree.
TEST(FindTurnedMount, SaysWhichFitIsBest) {
  const Eigen::Vector3d off(0.2, 0.0, 0.0);
  const GyroscopeFit right = Draw(1, 40, 0.01, off);
  GyroscopeFit apart;
  std::mt19937 rng(2);
  std::normal_distribution<double> normal(0.0, 0.01);
  for (int i = 0; i < 40; ++i) {
    apart.Add({normal(rng), normal(rng), normal(rng)}, {normal(rng), normal(rng), normal(rng)},
              kStep);
  }
  const auto found = FindTurnedMount(std::vector{apart, right, apart}, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->fit, 1u);
}

}  // namespace
}  // namespace highwall::turned_mount_test
