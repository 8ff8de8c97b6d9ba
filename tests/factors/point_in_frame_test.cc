#include <highwall/factors/point_in_frame.h>

#include <cmath>
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

namespace highwall::point_in_frame_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr};

struct Twin {
  Eigen::Vector3d p_F;
  Eigen::Matrix3d W;

  template <typename T>
  bool operator()(const T* T_WF, const T* point, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> p_WF(T_WF), p_W(point);
    const Eigen::Map<const Eigen::Quaternion<T>> q_WF(T_WF + 3);
    Eigen::Map<Vector3> r(residuals);
    r = W.cast<T>() * (q_WF.conjugate() * Vector3(p_W - p_WF) - p_F.cast<T>());
    return true;
  }
};

TEST(PointInFrame, ComputedByHand) {
  // F is at (1, 2, 3), rotated by a quarter turn about z: (1, 4, 3.5) is at (2, 0, 0.5) in it.
  const Pose T_WF = Pose::FromTangent({1, 2, 3}, {0, 0, 0.5 * M_PI});
  const PointInFrame f({1.5, 1, 0}, Eigen::Vector3d(2, 1, 4).asDiagonal().toDenseMatrix());
  EXPECT_LT((Residual(f, {ToBlock(T_WF), ToBlock(Eigen::Vector3d(1, 4, 3.5))}) -
             Eigen::Vector3d(1, -1, 2))
                .norm(),
            1e-12);
}

TEST(PointInFrame, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(52);
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    const Twin twin{RandomVector(rng, 5.0), RandomWeight(rng)};
    const PointInFrame f(twin.p_F, twin.W);
    const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), ToBlock(RandomVector(rng, 5.0))};
    const auto check = testing::CheckJacobians(f, blocks, kManifolds);
    EXPECT_TRUE(check) << check.message;
    const ceres::AutoDiffCostFunction<Twin, 3, 7, 3> autodiff(new Twin(twin));
    ExpectTwins(f, autodiff, blocks, kManifolds, 1e-11);
  }
}

TEST(PointInFrame, DoesNotChangeWhenTheWorldMoves) {
  std::mt19937 rng(53);
  const PointInFrame f(RandomVector(rng, 5.0), RandomWeight(rng));
  const Pose T_WF = RandomPose(rng), T_NW = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomVector(rng, 5.0);
  EXPECT_LT((Residual(f, {ToBlock(T_WF), ToBlock(p_W)}) -
             Residual(f, {ToBlock(T_NW * T_WF), ToBlock(Eigen::Vector3d(T_NW * p_W))}))
                .norm(),
            1e-11);
}

TEST(PointInFrame, LeavesADirectionWithoutARowOpen) {
  const PointInFrame f({0, 0, 5}, Eigen::Vector3d(2, 2, 0).asDiagonal().toDenseMatrix());
  EXPECT_EQ(Residual(f, {ToBlock(Pose()), ToBlock(Eigen::Vector3d(0, 0, 9))}).norm(), 0.0);
}

TEST(PointInFrame, SolvingFindsTheFrameOfThreePoints) {
  std::mt19937 rng(55);
  const Pose truth = RandomPose(rng);
  FactorGraph graph;
  const auto frame =
      graph.AddVariable(truth * Pose::FromTangent({0.5, -0.3, 0.2}, {0.2, 0.1, -0.3}));
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d p_F = RandomVector(rng, 5.0);
    const auto point = graph.AddVariable(Point(truth * p_F));
    graph.Fix(point);
    graph.AddFactor(std::make_unique<PointInFrame>(p_F, 10.0 * Eigen::Matrix3d::Identity()), frame,
                    point);
  }
  ASSERT_TRUE(
      graph.Solve({.max_iterations = 100, .function_tolerance = 0.0, .parameter_tolerance = 1e-14})
          .IsUsable());
  // Three non-collinear points determine the frame exactly.
  EXPECT_LT((graph.Value(frame).p() - truth.p()).norm(), 1e-9);
  EXPECT_LT((graph.Value(frame).Inverse() * truth).Angle(), 1e-9);
}

TEST(PointInFrame, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  EXPECT_THROW(PointInFrame({nan, 0, 0}, I), InvalidArgument);
  EXPECT_THROW(PointInFrame({0, 0, 0}, nan * I), InvalidArgument);
}

TEST(PointInFrame, FailsWhereAValueIsNotFinite) {
  const PointInFrame f(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  const Block frame = ToBlock(Pose());
  const Block point = ToBlock(Eigen::Vector3d(0, std::numeric_limits<double>::infinity(), 0));
  const double* blocks[] = {frame.data(), point.data()};
  double r[3];
  EXPECT_FALSE(f.Evaluate(blocks, r, nullptr));
}

}  // namespace
}  // namespace highwall::point_in_frame_test
