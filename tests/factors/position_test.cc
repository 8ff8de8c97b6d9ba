#include <highwall/factors/position.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"

namespace highwall::position_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, &kPoseManifold};

struct Twin {
  Eigen::Vector3d p_G, l;
  Eigen::Matrix3d W;

  template <typename T>
  bool operator()(const T* T_WB, const T* T_GW, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> p_WB(T_WB), p_GW(T_GW);
    const Eigen::Map<const Eigen::Quaternion<T>> q_WB(T_WB + 3), q_GW(T_GW + 3);
    const Vector3 l_W = q_WB * l.cast<T>() + p_WB;
    Eigen::Map<Vector3> r(residuals);
    r = W.cast<T>() * (q_GW * l_W + p_GW - p_G.cast<T>());
    return true;
  }
};

TEST(PositionFactor, ComputedByHand) {
  // A body at (1, 2, 3) looks along y of W, with its antenna 0.5 m ahead. G is W rotated by a
  // quarter turn about z and translated: (1, 2.5, 3) -> (-2.5, 1, 3) + (10, 20, 30).
  const Pose T_WB = Pose::FromTangent({1, 2, 3}, {0, 0, 0.5 * M_PI});
  const Pose T_GW = Pose::FromTangent({10, 20, 30}, {0, 0, 0.5 * M_PI});
  const PositionFactor f({7, 21.5, 33.25}, {0.5, 0, 0},
                         Eigen::Vector3d(2, 2, 4).asDiagonal().toDenseMatrix());
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(T_GW)}) - Eigen::Vector3d(1, -1, -1)).norm(),
            1e-12);
}

TEST(PositionFactor, WeighsTheErrorByTheSquareRootOfTheInformation) {
  std::mt19937 rng(41);
  const Eigen::Vector3d p_G = RandomVector(rng, 5.0), l = RandomVector(rng, 1.0);
  const Eigen::Matrix3d W = RandomWeight(rng);
  const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), ToBlock(RandomPose(rng))};
  const PositionFactor plain(p_G, l, Eigen::Matrix3d::Identity()), weighed(p_G, l, W);
  EXPECT_LT((Residual(weighed, blocks) - W * Residual(plain, blocks)).norm(), 1e-12);
}

TEST(PositionFactor, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(42);
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    const Twin twin{RandomVector(rng, 5.0), RandomVector(rng, 1.0), RandomWeight(rng)};
    const PositionFactor f(twin.p_G, twin.l, twin.W);
    const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), ToBlock(RandomPose(rng))};
    const auto check = testing::CheckJacobians(f, blocks, kManifolds);
    EXPECT_TRUE(check) << check.message;
    const ceres::AutoDiffCostFunction<Twin, 3, 7, 7> autodiff(new Twin(twin));
    ExpectTwins(f, autodiff, blocks, kManifolds, 1e-11);
  }
}

TEST(PositionFactor, DoesNotChangeWhenTheWorldMoves) {
  std::mt19937 rng(43);
  const PositionFactor f(RandomVector(rng, 5.0), RandomVector(rng, 1.0), RandomWeight(rng));
  const Pose T_WB = RandomPose(rng), T_GW = RandomPose(rng), T_NW = RandomPose(rng);
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(T_GW)}) -
             Residual(f, {ToBlock(T_NW * T_WB), ToBlock(T_GW * T_NW.Inverse())}))
                .norm(),
            1e-11);
}

TEST(PositionFactor, WithoutALeverArmTheBodyMayTurn) {
  std::mt19937 rng(44);
  const PositionFactor f(RandomVector(rng, 5.0), Eigen::Vector3d::Zero(), RandomWeight(rng));
  const Pose T_WB = RandomPose(rng), T_GW = RandomPose(rng);
  const Pose turned = T_WB * Pose::FromTangent({0, 0, 0}, RandomVector(rng, 1.0));
  EXPECT_LT(
      (Residual(f, {ToBlock(T_WB), ToBlock(T_GW)}) - Residual(f, {ToBlock(turned), ToBlock(T_GW)}))
          .norm(),
      1e-12);
}

TEST(PositionFactor, SolvingFindsTheAlignmentOfAWay) {
  std::mt19937 rng(45);
  // Coordinates of a large grid.
  const Pose truth = Pose::FromTangent({4.5e5, 5.4e6, 300}, {0, 0, 2.0});
  const Eigen::Vector3d l(0.2, -0.1, 0.5);
  FactorGraph graph;
  const auto alignment = graph.AddVariable(Pose::FromTangent({0, 0, 0}, {0.1, 0.1, 1.0}));
  for (int i = 0; i < 20; ++i) {
    // The path is straight, so only the prior determines the rotation about it.
    const Pose T_WB = Pose::FromTangent({0.5 * i, 0.0, 0.0}, {0, 0, 0});
    const auto pose = graph.AddVariable(T_WB);
    graph.Fix(pose);
    graph.AddFactor(
        std::make_unique<PositionFactor>(truth * (T_WB * l), l, 10.0 * Eigen::Matrix3d::Identity()),
        pose, alignment);
  }
  graph.AddFactor(std::make_unique<GravityPrior>(0.01), alignment);
  ASSERT_TRUE(
      graph.Solve({.max_iterations = 100, .function_tolerance = 0.0, .parameter_tolerance = 1e-14})
          .IsUsable());
  // At coordinates of 5e6 m a double resolves 1e-9 m.
  EXPECT_LT((graph.Value(alignment).p() - truth.p()).norm(), 1e-6);
  EXPECT_LT((graph.Value(alignment).Inverse() * truth).Angle(), 1e-7);
}

TEST(PositionFactor, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  EXPECT_THROW(PositionFactor({nan, 0, 0}, zero, I), InvalidArgument);
  EXPECT_THROW(PositionFactor(zero, {0, nan, 0}, I), InvalidArgument);
  EXPECT_THROW(PositionFactor(zero, zero, nan * I), InvalidArgument);
}

TEST(PositionFactor, FailsWhereAValueIsNotFinite) {
  const PositionFactor f(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                         Eigen::Matrix3d::Identity());
  const Block good = ToBlock(Pose());
  Block bad = good;
  bad[1] = std::numeric_limits<double>::infinity();
  const double* blocks[] = {good.data(), bad.data()};
  double r[3];
  EXPECT_FALSE(f.Evaluate(blocks, r, nullptr));
}

}  // namespace
}  // namespace highwall::position_test
