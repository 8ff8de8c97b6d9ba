#include <highwall/factors/intrinsic_reprojection.h>

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/point_reprojection.h>

#include "reprojection_scene.h"

namespace highwall::intrinsic_reprojection_test {
namespace {

Eigen::Matrix3d TestWeight() {
  return (Eigen::Matrix3d() << 0.8, 0.1, 0.3, -0.2, 1.3, 0.0, 0.5, -0.4, 4.0).finished();
}

// Weights half of one node and half of its neighbour.
DepthPattern::Vector Shares() {
  DepthPattern::Vector shares = DepthPattern::Vector::Zero();
  shares[6] = shares[7] = 0.5;
  return shares;
}
const Block kNoPattern(DepthPattern::kNodes, 0.0);

TEST(IntrinsicReprojection, MatchesHandComputedValues) {
  // x/z = 0.1, y/z = -0.2, and c/z = 50 / 2.
  const ProjectionRows<3> rows =
      PointRows(Eigen::Vector3d(370.0, 160.0, 24.0), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  const IntrinsicReprojection f(rows, SimpleProjection(), Shares());
  const Block pose = ToBlock(Pose());
  EXPECT_LT(
      (Residual(f, {pose, {0.2, -0.4, 2.0}, {500.0, 400.0, 320.0, 240.0}, {0.0}, kNoPattern}) -
       Eigen::Vector3d(0.0, 0.0, 1.0))
          .norm(),
      1e-12);
  EXPECT_LT(
      (Residual(f, {pose, {0.2, -0.4, 2.0}, {510.0, 420.0, 323.0, 244.0}, {0.0}, kNoPattern}) -
       Eigen::Vector3d(4.0, 0.0, 1.0))
          .norm(),
      1e-12);
  // A disparity of 50 px m / 2 m, and an additional 50 px m * 0.02 / m.
  EXPECT_LT(
      (Residual(f, {pose, {0.2, -0.4, 2.0}, {500.0, 400.0, 320.0, 240.0}, {0.02}, kNoPattern}) -
       Eigen::Vector3d(0.0, 0.0, 2.0))
          .norm(),
      1e-12);
  // The same with a pattern of 0.01 and 0.03 at the nodes next to the pixel.
  Block pattern = kNoPattern;
  pattern[6] = 0.01;
  pattern[7] = 0.03;
  pattern[8] = 0.5;
  EXPECT_LT((Residual(f, {pose, {0.2, -0.4, 2.0}, {500.0, 400.0, 320.0, 240.0}, {0.0}, pattern}) -
             Eigen::Vector3d(0.0, 0.0, 2.0))
                .norm(),
            1e-12);
}

TEST(IntrinsicReprojection, IsPointReprojectionAtTheCalibratedIntrinsics) {
  std::mt19937 rng(70);
  twins::Rig rig = TestRig();
  rig.T_BC = Pose();
  const PinholeCamera& camera = rig.camera;
  for (int i = 0; i < 20; ++i) {
    const Pose T_WC = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WC), z(300.0, 200.0, 15.0);
    const PointReprojectionRgbd g(z, TestWeight(), Projection(rig));
    const IntrinsicReprojection f(PointRows(z, TestWeight()), Projection(rig), Shares());
    EXPECT_LT((Residual(f, {ToBlock(T_WC),
                            ToBlock(p_W),
                            {camera.fx, camera.fy, camera.cx, camera.cy},
                            {0.0},
                            kNoPattern}) -
               Residual(g, {ToBlock(T_WC), ToBlock(p_W)}))
                  .norm(),
              1e-9);
  }
}

TEST(IntrinsicReprojection, JacobiansMatchCentralDifferences) {
  const PoseManifold manifold;
  std::mt19937 rng(71);
  twins::Rig rig = TestRig();
  rig.T_BC = Pose();
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    const Pose T_WC = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WC);
    const Eigen::Vector3d z = Observe(rig, T_WC, p_W) + Eigen::Vector3d(20.0, -10.0, 2.0);
    const IntrinsicReprojection f(PointRows(z, TestWeight()), Projection(rig), Shares());
    const Block k = {Uniform(rng, 400, 600), Uniform(rng, 400, 600), Uniform(rng, 300, 340),
                     Uniform(rng, 220, 260)};
    const Block offset = {Uniform(rng, -0.02, 0.02)};
    Block pattern = kNoPattern;
    for (double& node : pattern) node = Uniform(rng, -0.02, 0.02);
    const auto check = testing::CheckJacobians(f, {ToBlock(T_WC), ToBlock(p_W), k, offset, pattern},
                                               {&manifold, nullptr, nullptr, nullptr, nullptr});
    EXPECT_TRUE(check) << check.message;
  }
}

TEST(IntrinsicReprojection, IsInactiveNearerThanTheMinimalDepth) {
  const IntrinsicReprojection f(PointRows(Eigen::Vector3d(1, 2, 3), TestWeight()),
                                SimpleProjection(), Shares());
  const double near = 0.5 * RgbdProjection::kDefaultMinDepth;
  EXPECT_EQ(
      Residual(f, {ToBlock(Pose()), {0.0, 0.0, near}, {500, 400, 320, 240}, {0.0}, kNoPattern}),
      Eigen::Vector3d::Zero());
}

TEST(IntrinsicReprojection, RefusesRowsThatAreNotFinite) {
  ProjectionRows<3> rows = PointRows(Eigen::Vector3d(1, 2, 3), TestWeight());
  rows.b[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(IntrinsicReprojection(rows, SimpleProjection(), Shares()), InvalidArgument);
  rows.b[1] = 0.0;
  DepthPattern::Vector shares = Shares();
  shares[0] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(IntrinsicReprojection(rows, SimpleProjection(), shares), InvalidArgument);
}

}  // namespace
}  // namespace highwall::intrinsic_reprojection_test
