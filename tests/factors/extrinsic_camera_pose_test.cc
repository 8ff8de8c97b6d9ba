#include <highwall/factors/camera_pose.h>

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/calibration_twins.h"
#include "support/imu_scene.h"

namespace highwall::extrinsic_camera_pose_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr, nullptr,
                                                        &kPoseManifold, nullptr};

Matrix6 TestWeight(std::mt19937& rng) {
  Matrix6 W = 2.0 * Matrix6::Identity();
  for (double& w : W.reshaped()) w += Uniform(rng, -1.0, 1.0);
  return W;
}

TEST(ExtrinsicCameraPose, IsCameraPoseWhereScaleIsOneAndTheExtrinsicsAreKnown) {
  std::mt19937 rng(110);
  for (int i = 0; i < 10; ++i) {
    const Pose T_0 = RandomPose(rng), T_BC = RandomPose(rng);
    const Matrix6 W = TestWeight(rng);
    const Eigen::Vector3d omega_B = RandomVector(rng, 2.0);
    const CameraPose known(T_0, W, T_BC, omega_B, 0.01);
    const ExtrinsicCameraPose f(T_0, W, omega_B, 0.01);
    const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), {1, 2, 3}, {0.03}};
    const std::vector<Block> all = {blocks[0], blocks[1], blocks[2], ToBlock(T_BC), {1.0}};
    EXPECT_LT((Residual(f, all) - Residual(known, blocks)).norm(), 1e-12);
    EXPECT_LT((TangentJacobian(f, all, kManifolds).leftCols<10>() -
               TangentJacobian(known, blocks, {&kPoseManifold, nullptr, nullptr}))
                  .norm(),
              1e-11);
  }
}

TEST(ExtrinsicCameraPose, AScaleMakesTheTrueMotionAsLargeAsTheMeasuredOne) {
  const ExtrinsicCameraPose f(Pose(), Matrix6::Identity(), Eigen::Vector3d::Zero());
  Vector6 expected;
  expected << 1.0, 2.0, 3.0, 0, 0, 0;
  const Block there = ToBlock(Pose::FromTangent({1.1, 2.2, 3.3}, {0, 0, 0}));
  EXPECT_LT((Residual(f, {there, {0, 0, 0}, {0.0}, ToBlock(Pose()), {1.1}}) - expected).norm(),
            1e-14);
}

TEST(ExtrinsicCameraPose, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(111);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    // Angles of the rotation error, including tiny ones and ones near pi.
    const double angle = i % 3 == 0 ? 1e-8 : i % 3 == 1 ? Uniform(rng, 0.1, 2.0) : M_PI - 1e-3;
    const Pose T_WB = RandomPose(rng), T_BC = RandomPose(rng);
    const Matrix6 W = TestWeight(rng);
    const Eigen::Vector3d omega_B = RandomVector(rng, 2.0), v_WB = RandomVector(rng, 2.0);
    const double d = Uniform(rng, -0.1, 0.1), s = Uniform(rng, 0.8, 1.2);
    const Pose at(T_WB.q() * so3::Exp(d * omega_B), T_WB.p() + d * v_WB);
    Vector6 error;
    error << RandomVector(rng, 0.5), angle * RandomVector(rng, 1.0).normalized();
    const Pose T_WC_0 = (at * T_BC).Plus(error);
    const ExtrinsicCameraPose f(T_WC_0, W, omega_B, 0.01);
    const std::vector<Block> blocks = {
        ToBlock(T_WB), ToBlock(v_WB), {0.01 + d}, ToBlock(T_BC), {s}};
    const auto check = testing::CheckJacobians(f, blocks, kManifolds);
    EXPECT_TRUE(check) << check.message;
    ExpectTwins(f, *twins::MakeExtrinsicCameraPose({T_WC_0, W, omega_B, 0.01}), blocks, kManifolds,
                1e-10);
  }
}

TEST(ExtrinsicCameraPose, FindsTheExtrinsicsOfABodyWhoseMotionIsKnown) {
  std::mt19937 rng(112);
  const Pose T_BC(so3::Exp({0.5, -1.0, 0.3}), {0.1, -0.05, 0.2});
  const double s = 0.96, t_d = 0.02;
  FactorGraph graph;
  const auto extrinsics = graph.AddVariable(Pose(so3::Exp({0.3, -0.8, 0.4}), {0, 0, 0}));
  const auto offset = graph.AddVariable(0.0);
  const auto scale = graph.AddVariable(1.0);
  for (int i = 0; i < 12; ++i) {
    const Pose T_WB = RandomPose(rng);
    const Eigen::Vector3d v_WB = RandomVector(rng, 1.0), omega_B = RandomVector(rng, 1.0);
    const Pose T_WC = Pose(T_WB.q() * so3::Exp(t_d * omega_B), T_WB.p() + t_d * v_WB) * T_BC;
    const auto pose = graph.AddVariable(T_WB);
    const auto velocity = graph.AddVariable(v_WB);
    graph.Fix(pose);
    graph.Fix(velocity);
    graph.AddFactor(std::make_unique<ExtrinsicCameraPose>(Pose(T_WC.q(), T_WC.p() / s),
                                                          Matrix6::Identity(), omega_B),
                    pose, velocity, offset, extrinsics, scale);
  }
  graph.Solve({.function_tolerance = 1e-14});
  const Pose error = T_BC.Inverse() * graph.Value(extrinsics);
  EXPECT_LT(error.p().norm(), 1e-7);
  EXPECT_LT(so3::Log(error.q()).norm(), 1e-7);
  EXPECT_NEAR(graph.Value(offset), t_d, 1e-8);
  EXPECT_NEAR(graph.Value(scale), s, 1e-8);
}

TEST(ExtrinsicCameraPose, RefusesNonFiniteArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Matrix6 W = Matrix6::Identity();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  EXPECT_THROW(ExtrinsicCameraPose(Pose(Eigen::Quaterniond::Identity(), {nan, 0, 0}), W, zero),
               InvalidArgument);
  EXPECT_THROW(ExtrinsicCameraPose(Pose(), nan * W, zero), InvalidArgument);
  EXPECT_THROW(ExtrinsicCameraPose(Pose(), W, {nan, 0, 0}), InvalidArgument);
  EXPECT_THROW(ExtrinsicCameraPose(Pose(), W, zero, nan), InvalidArgument);
}

}  // namespace
}  // namespace highwall::extrinsic_camera_pose_test
