#include <highwall/factors/point_to_plane.h>

#include <limits>
#include <memory>
#include <random>

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"

namespace highwall::point_to_plane_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, &kPoseManifold};

struct Twin {
  PointToPlaneRow row;

  template <typename T>
  bool operator()(const T* T_WR, const T* T_WB, T* r) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> p_WR(T_WR), p_WB(T_WB);
    const Eigen::Map<const Eigen::Quaternion<T>> q_WR(T_WR + 3), q_WB(T_WB + 3);
    const Vector3 p_W = q_WB * row.p.cast<T>() + p_WB;
    const Vector3 p_R = q_WR.conjugate() * Vector3(p_W - p_WR);
    *r = T(row.inverse_sigma) * row.n.cast<T>().dot(p_R - row.a.cast<T>());
    return true;
  }
};

PointToPlaneRow RandomRow(std::mt19937& rng) {
  return {RandomVector(rng, 1.0).normalized(), RandomVector(rng, 3.0), RandomVector(rng, 3.0),
          Uniform(rng, 10.0, 1000.0)};
}

TEST(PointToPlane, IsTheDistanceInSigmas) {
  // The plane is z = 2 of R, and the point is 0.5 m ahead of a body 1.6 m ahead of R: 0.1 m behind
  // it.
  const PointToPlane f({{0, 0, 1}, {7, -3, 2}, {0.3, 0.4, 0.5}, 100.0});
  const Pose T_WR = Pose::FromTangent({1, 2, 3}, {0, 0, 0});
  const Pose T_WB = Pose::FromTangent({1, 2, 4.6}, {0, 0, 0});
  EXPECT_NEAR(Residual(f, {ToBlock(T_WR), ToBlock(T_WB)})(0), 10.0, 1e-12);
}

TEST(PointToPlane, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(31);
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    const PointToPlaneRow row = RandomRow(rng);
    const PointToPlane f(row);
    const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), ToBlock(RandomPose(rng))};
    const auto check = testing::CheckJacobians(f, blocks, kManifolds);
    EXPECT_TRUE(check) << check.message;
    const ceres::AutoDiffCostFunction<Twin, 1, 7, 7> twin(new Twin{row});
    ExpectTwins(f, twin, blocks, kManifolds, 1e-10);
  }
}

TEST(PointToPlane, TheRowOfAKnownPlaneIsTheFactorWithItsFrameAtTheOrigin) {
  std::mt19937 rng(32);
  const PointToPlaneRow row = RandomRow(rng);
  const Pose T_WB = RandomPose(rng);
  const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(T_WB)};
  Eigen::Matrix<double, 1, 6> J;
  const double r = row.Evaluate(T_WB.R(), T_WB.p(), &J);
  const PointToPlane f(row);
  // For numbers up to 1e4.
  EXPECT_NEAR(r, Residual(f, blocks)(0), 1e-9);
  EXPECT_LT((J - TangentJacobian(f, blocks, kManifolds).rightCols<6>()).norm(), 1e-9);
}

TEST(PointToPlane, DoesNotChangeWhenTheWorldFrameMoves) {
  std::mt19937 rng(33);
  const PointToPlane f(RandomRow(rng));
  const Pose T_WR = RandomPose(rng), T_WB = RandomPose(rng), T_NW = RandomPose(rng);
  EXPECT_NEAR(Residual(f, {ToBlock(T_WR), ToBlock(T_WB)})(0),
              Residual(f, {ToBlock(T_NW * T_WR), ToBlock(T_NW * T_WB)})(0), 1e-9);
}

TEST(PointToPlane, SlidingAlongThePlaneCostsNothing) {
  std::mt19937 rng(34);
  const PointToPlaneRow row = RandomRow(rng);
  const PointToPlane f(row);
  const Pose T_WB = RandomPose(rng);
  const Eigen::Vector3d along = row.n.unitOrthogonal();
  const Pose slid(T_WB.q(), T_WB.p() + 3.0 * along);
  EXPECT_NEAR(Residual(f, {ToBlock(Pose()), ToBlock(T_WB)})(0),
              Residual(f, {ToBlock(Pose()), ToBlock(slid)})(0), 1e-9);
}

TEST(PointToPlane, SolvingFindsThePoseInACorner) {
  std::mt19937 rng(35);
  FactorGraph graph;
  const Pose truth = RandomPose(rng), T_WR = RandomPose(rng);
  const auto reference = graph.AddVariable(T_WR);
  Eigen::Matrix<double, 6, 1> away;
  away << RandomVector(rng, 0.3), RandomVector(rng, 0.2);
  const auto pose = graph.AddVariable(truth.Plus(away));
  graph.Fix(reference);
  for (int i = 0; i < 30; ++i) {
    Eigen::Vector3d p_R = RandomVector(rng, 2.0);
    p_R(i % 3) = 2.0;
    const Eigen::Vector3d p_B = truth.Inverse() * (T_WR * p_R);
    graph.AddFactor(std::make_unique<PointToPlane>(
                        PointToPlaneRow{Eigen::Vector3d::Unit(i % 3), {2.0, 2.0, 2.0}, p_B, 100.0}),
                    reference, pose);
  }
  ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
  EXPECT_LT((graph.Value(pose).p() - truth.p()).norm(), 1e-8);
  EXPECT_LT((graph.Value(pose).Inverse() * truth).Angle(), 1e-8);
}

TEST(PointToPlane, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PointToPlane({.a = {nan, 0, 0}}), InvalidArgument);
  EXPECT_THROW(PointToPlane({.p = {nan, 0, 0}}), InvalidArgument);
  EXPECT_THROW(PointToPlane({.n = {0, 0, 2}}), InvalidArgument);
  EXPECT_THROW(PointToPlane({.inverse_sigma = 0.0}), InvalidArgument);
}

TEST(PointToPlane, FailsWhereAValueIsNotFinite) {
  const PointToPlane f(PointToPlaneRow{});
  Block bad = ToBlock(Pose());
  bad[0] = std::numeric_limits<double>::infinity();
  const Block good = ToBlock(Pose());
  const double* blocks[] = {good.data(), bad.data()};
  double r = 0.0;
  EXPECT_FALSE(f.Evaluate(blocks, &r, nullptr));
}

}  // namespace
}  // namespace highwall::point_to_plane_test
