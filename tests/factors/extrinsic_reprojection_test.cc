#include <highwall/factors/extrinsic_reprojection.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/calibration_twins.h"

namespace highwall::extrinsic_reprojection_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr, &kPoseManifold};

Eigen::Matrix3d TestWeight() {
  return (Eigen::Matrix3d() << 0.8, 0.1, 0.3, -0.2, 1.3, 0.0, 0.5, -0.4, 4.0).finished();
}

TEST(ExtrinsicReprojection, MatchesHandComputedValues) {
  PinholeCamera camera;
  camera.fx = camera.fy = 500.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  const PointReprojectionExtrinsics f({320.0, 240.0}, Eigen::Matrix2d::Identity(),
                                      RgbdProjection(camera, Pose()));
  // The body is 1 m back, the camera 0.5 m ahead of it and 0.1 m to the right: p_C = (-0.1, 0,
  // 2.5).
  const Pose T_WB = Pose::FromTangent({0, 0, -1}, {0, 0, 0});
  const Pose T_BC = Pose::FromTangent({0.1, 0, 0.5}, {0, 0, 0});
  EXPECT_LT(
      (Residual(f, {ToBlock(T_WB), {0, 0, 2}, ToBlock(T_BC)}) - Eigen::Vector2d(-20.0, 0.0)).norm(),
      1e-12);
}

TEST(ExtrinsicReprojection, IsPointReprojectionAtTheCalibratedExtrinsics) {
  std::mt19937 rng(90);
  const twins::Rig rig = TestRig();
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB), z(300.0, 200.0, 15.0);
    // The extrinsics of the projection must not have an effect.
    const RgbdProjection other(rig.camera, RandomPose(rng), rig.right);
    const PointReprojectionRgbdExtrinsics f(z, TestWeight(), other);
    const PointReprojectionRgbd g(z, TestWeight(), Projection(rig));
    EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC)}) -
               Residual(g, {ToBlock(T_WB), ToBlock(p_W)}))
                  .norm(),
              1e-9);
  }
}

template <int kRows>
void CheckAt(const twins::Rig& rig, const Pose& T_WB, const Eigen::Vector3d& p_W) {
  const Eigen::Matrix<double, kRows, 1> z =
      (Observe(rig, T_WB, p_W) + Eigen::Vector3d(20.0, -10.0, 2.0)).head<kRows>();
  const Eigen::Matrix<double, kRows, kRows> W = TestWeight().topLeftCorner<kRows, kRows>();
  const ExtrinsicReprojection<kRows> f(z, W, Projection(rig));
  const std::vector<Block> blocks = {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC)};
  const auto check = testing::CheckJacobians(f, blocks, kManifolds);
  EXPECT_TRUE(check) << check.message;
  ExpectTwins(f, *twins::MakeExtrinsics<kRows>({{rig, z, W}}), blocks, kManifolds, 1e-10);
}

TEST(ExtrinsicReprojection, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(91);
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    twins::Rig rig = TestRig();
    rig.T_BC = RandomPose(rng);
    const Pose T_WB = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
    CheckAt<2>(rig, T_WB, p_W);
    CheckAt<3>(rig, T_WB, p_W);
  }
  twins::Rig rig = TestRig();
  rig.T_BC = Pose::FromTangent({0.1, 0, 0}, {0, M_PI, 0});
  const double depth = RgbdProjection::kDefaultMinDepth + 1e-5;
  CheckAt<3>(rig, Pose(), rig.T_BC * Eigen::Vector3d(0.01, -0.008, depth));
}

TEST(ExtrinsicReprojection, DoesNotChangeWhenTheWorldOrTheBodyFrameMoves) {
  std::mt19937 rng(92);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng), T_NW = RandomPose(rng), T_BD = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  const PointReprojectionRgbdExtrinsics f({300, 200, 15}, TestWeight(), Projection(rig));
  const Eigen::VectorXd r = Residual(f, {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC)});
  EXPECT_LT((Residual(f, {ToBlock(T_NW * T_WB), ToBlock(Eigen::Vector3d(T_NW * p_W)),
                          ToBlock(rig.T_BC)}) -
             r)
                .norm(),
            1e-9);
  EXPECT_LT(
      (Residual(f, {ToBlock(T_WB * T_BD), ToBlock(p_W), ToBlock(T_BD.Inverse() * rig.T_BC)}) - r)
          .norm(),
      1e-9);
}

TEST(ExtrinsicReprojection, SolvesForTheExtrinsicsFromKnownPosesAndPoints) {
  std::mt19937 rng(93);
  const twins::Rig rig = TestRig();
  FactorGraph graph;
  const auto T_BC = graph.AddVariable(rig.T_BC.Plus(
      (Eigen::Matrix<double, 6, 1>() << 0.05, -0.05, 0.05, 0.1, -0.1, 0.1).finished()));
  for (int k = 0; k < 5; ++k) {
    const Pose T_WB = RandomPose(rng);
    const auto pose = graph.AddVariable(T_WB);
    graph.Fix(pose);
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
      const auto point = graph.AddVariable(p_W);
      graph.Fix(point);
      graph.AddFactor(
          std::make_unique<PointReprojectionExtrinsics>(
              Observe(rig, T_WB, p_W).head<2>(), Eigen::Matrix2d::Identity(), Projection(rig)),
          pose, point, T_BC);
    }
  }
  SolveOptions options;
  options.function_tolerance = 1e-20;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  EXPECT_LT((graph.Value(T_BC).p() - rig.T_BC.p()).norm(), 1e-9);
  EXPECT_LT((rig.T_BC.Inverse() * graph.Value(T_BC)).Angle(), 1e-9);
}

TEST(ExtrinsicReprojection, IsInactiveNearerThanTheMinimalDepth) {
  const twins::Rig rig = TestRig();
  const PointReprojectionRgbdExtrinsics f({1, 2, 3}, Eigen::Matrix3d::Identity(), Projection(rig));
  for (const double depth : {0.04, -1.0}) {
    const Eigen::Vector3d p_W = rig.T_BC * Eigen::Vector3d(0.1, 0.2, depth);
    const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(p_W), ToBlock(rig.T_BC)};
    EXPECT_EQ(Residual(f, blocks).norm(), 0.0);
    EXPECT_EQ(TangentJacobian(f, blocks, kManifolds).norm(), 0.0);
  }
}

TEST(ExtrinsicReprojection, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RgbdProjection projection = Projection(TestRig());
  EXPECT_THROW(PointReprojectionExtrinsics({nan, 0}, Eigen::Matrix2d::Identity(), projection),
               InvalidArgument);
  EXPECT_THROW(
      PointReprojectionRgbdExtrinsics({0, 0, 1}, Eigen::Matrix3d::Constant(nan), projection),
      InvalidArgument);
}

}  // namespace
}  // namespace highwall::extrinsic_reprojection_test
