#include "planar_relative_pose.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/testing/jacobian_check.h>

#include "random_states.h"

namespace highwall::planar_relative_pose_test {
namespace {

using internal::PlanarRelativePose;

Eigen::Vector3d RandomPlanar(RandomStates* random) {
  return {random->Uniform(-3, 3), random->Uniform(-3, 3), random->Uniform(-3, 3)};
}

Eigen::Vector3d Residual(const PlanarRelativePose& factor, const Eigen::Vector3d& i,
                         const Eigen::Vector3d& j) {
  const double* const blocks[] = {i.data(), j.data()};
  Eigen::Vector3d r;
  EXPECT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  return r;
}

TEST(PlanarRelativePose, OfAQuarterTurnComputedByHand) {
  // j lies at (1, 2) in i. The measured frame is at (1, 0) and rotated left, so j is 2 ahead in it.
  const PlanarRelativePose factor({1, 0, 0.5 * M_PI}, Eigen::Vector3d(1, 2, 3).asDiagonal());
  const Eigen::Vector3d r = Residual(factor, {0, 0, 0}, {1, 2, 0.5 * M_PI + 0.1});
  EXPECT_TRUE(r.isApprox(Eigen::Vector3d(2, 0, 0.3), 1e-14)) << r.transpose();
}

TEST(PlanarRelativePose, WrapsWholeTurns) {
  const PlanarRelativePose factor({1, 0, 3.0}, Eigen::Matrix3d::Identity());
  for (const double turns : {-2.0, 0.0, 5.0}) {
    const Eigen::Vector3d r = Residual(factor, {0, 0, 0}, {1, 0, 3.2 + 2.0 * M_PI * turns});
    EXPECT_NEAR(r.z(), 0.2, 1e-14);
  }
}

TEST(PlanarRelativePose, JacobiansMatchCentralDifferences) {
  RandomStates random(1);
  for (int sample = 0; sample < 50; ++sample) {
    const PlanarRelativePose factor(RandomPlanar(&random), random.Matrix<3>());
    const Eigen::Vector3d i = RandomPlanar(&random), j = RandomPlanar(&random);
    const auto result = testing::CheckJacobians(
        factor, {{i.data(), i.data() + 3}, {j.data(), j.data() + 3}}, {nullptr, nullptr});
    EXPECT_TRUE(result) << "sample " << sample << ": " << result.message;
  }
}

TEST(PlanarRelativePose, DoesNotChangeWhenTheWorldFrameMoves) {
  RandomStates random(2);
  const PlanarRelativePose factor(RandomPlanar(&random), random.Matrix<3>());
  const Eigen::Vector3d i = RandomPlanar(&random), j = RandomPlanar(&random);
  const Eigen::Vector3d move = RandomPlanar(&random);
  const auto moved = [&](const Eigen::Vector3d& x) {
    const Eigen::Vector2d p = Eigen::Rotation2Dd(move.z()) * x.head<2>() + move.head<2>();
    return Eigen::Vector3d(p.x(), p.y(), x.z() + move.z());
  };
  EXPECT_TRUE(Residual(factor, i, j).isApprox(Residual(factor, moved(i), moved(j)), 1e-12));
}

TEST(PlanarRelativePose, ReturnsFalseOnNonFiniteStates) {
  const PlanarRelativePose factor({1, 0, 3.0}, Eigen::Matrix3d::Identity());
  const Eigen::Vector3d good(0, 0, 0), bad(0, std::numeric_limits<double>::quiet_NaN(), 0);
  const double* const blocks[] = {good.data(), bad.data()};
  Eigen::Vector3d r;
  EXPECT_FALSE(factor.Evaluate(blocks, r.data(), nullptr));
}

}  // namespace
}  // namespace highwall::planar_relative_pose_test
