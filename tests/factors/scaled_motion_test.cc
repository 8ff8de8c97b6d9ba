#include <highwall/factors/scaled_motion.h>

#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/calibration_twins.h"

namespace highwall::scaled_motion_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, &kPoseManifold, nullptr};
const Pose kT_BC = Pose::FromTangent({0.05, -0.03, 0.08}, {-1.2, 1.2, -1.2});

Matrix6 TestWeight(std::mt19937& rng) {
  Matrix6 W = 2.0 * Matrix6::Identity();
  for (double& w : W.reshaped()) w += Uniform(rng, -1.0, 1.0);
  return W;
}

// Returns the motion between two bodies as measured by a camera whose lengths are too short by the
// factor `scale`.
Pose Seen(const Pose& T_i, const Pose& T_j, double scale) {
  const Pose T_CiCj = (T_i * kT_BC).Inverse() * T_j * kT_BC;
  return Pose(T_CiCj.q(), T_CiCj.p() / scale);
}

TEST(ScaledMotion, ComputedByHand) {
  // The camera looks along x of the body, which is z of C, 0.5 m ahead of it. The body moves by 1 m
  // along x and rotates left by a quarter turn: the camera moves from (0.5, 0) to (1, 0.5), 0.5 m
  // ahead and 0.5 m to the left, where the camera's x points to the right.
  Eigen::Matrix4d T_BC;
  T_BC << 0, 0, 1, 0.5, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1;
  const Pose T_j = Pose::FromTangent({1, 0, 0}, {0, 0, 0.5 * std::numbers::pi});
  const Pose Z = Pose::FromTangent({-0.4, 0.1, 0.3}, {0, 0, 0});
  const ScaledMotion f(Z, Matrix6::Identity(), Pose::FromMatrix(T_BC));
  Vector6 expected;  // up is -y of C
  expected << -0.25 + 0.4, -0.1, 0.25 - 0.3, 0, -0.5 * std::numbers::pi, 0;
  const Eigen::VectorXd r = Residual(f, {ToBlock(Pose()), ToBlock(T_j), {2.0}});
  EXPECT_LT((r - expected).norm(), 1e-14);
}

TEST(ScaledMotion, IsZeroWhereTheScaleIsThatOfTheMeasurement) {
  std::mt19937 rng(120);
  for (int i = 0; i < 20; ++i) {
    const Pose T_i = RandomPose(rng), T_j = RandomPose(rng);
    const ScaledMotion f(Seen(T_i, T_j, 0.96), Matrix6::Identity(), kT_BC);
    EXPECT_LT(Residual(f, {ToBlock(T_i), ToBlock(T_j), {0.96}}).norm(), 1e-13);
    EXPECT_GT(Residual(f, {ToBlock(T_i), ToBlock(T_j), {1.0}}).norm(), 1e-3);
  }
}

TEST(ScaledMotion, WeighsTheErrorByTheSquareRootOfTheInformation) {
  std::mt19937 rng(121);
  const Matrix6 W = TestWeight(rng);
  const Pose Z = RandomPose(rng);
  const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), ToBlock(RandomPose(rng)), {1.1}};
  const Eigen::VectorXd plain = Residual(ScaledMotion(Z, Matrix6::Identity(), kT_BC), blocks);
  EXPECT_LT((Residual(ScaledMotion(Z, W, kT_BC), blocks) - W * plain).norm(), 1e-12);
}

TEST(ScaledMotion, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(122);
  for (int i = 0; i < 50; ++i) {
    const Matrix6 W = TestWeight(rng);
    const Pose T_i = RandomPose(rng), T_j = RandomPose(rng);
    // Away from the optimum and from the jump at pi.
    const Pose E = Pose::FromTangent(RandomVector(rng, 1.0), RandomVector(rng, 1.4));
    const Pose Z = Seen(T_i, T_j, 0.9) * E;
    const ScaledMotion f(Z, W, kT_BC);
    const std::vector<Block> blocks = {ToBlock(T_i), ToBlock(T_j), {Uniform(rng, 0.8, 1.2)}};
    const auto check = testing::CheckJacobians(f, blocks, kManifolds);
    EXPECT_TRUE(check) << i << ": " << check.message;
    ExpectTwins(f, *twins::MakeScaledMotion({Z, W, kT_BC}), blocks, kManifolds, 1e-12);
  }
}

TEST(ScaledMotion, JacobiansMatchAtTinyAnglesAndNearPi) {
  std::mt19937 rng(123);
  for (const double angle : {0.0, 1e-8, 1e-4, std::numbers::pi - 1e-3}) {
    const Pose T_i = RandomPose(rng), T_j = RandomPose(rng);
    const Eigen::Vector3d axis = RandomVector(rng, 1.0).normalized();
    const Pose Z = Seen(T_i, T_j, 1.0) * Pose::FromTangent({0.1, 0.2, 0.3}, angle * axis);
    const auto check = testing::CheckJacobians(ScaledMotion(Z, TestWeight(rng), kT_BC),
                                               {ToBlock(T_i), ToBlock(T_j), {1.0}}, kManifolds);
    EXPECT_TRUE(check) << angle << ": " << check.message;
  }
}

TEST(ScaledMotion, DoesNotChangeWhenTheWorldMoves) {
  std::mt19937 rng(124);
  const ScaledMotion f(RandomPose(rng), TestWeight(rng), kT_BC);
  for (int i = 0; i < 10; ++i) {
    const Pose T_i = RandomPose(rng), T_j = RandomPose(rng), G = RandomPose(rng);
    const Eigen::VectorXd r = Residual(f, {ToBlock(T_i), ToBlock(T_j), {0.9}});
    const Eigen::VectorXd moved = Residual(f, {ToBlock(G * T_i), ToBlock(G * T_j), {0.9}});
    EXPECT_LT((r - moved).norm(), 1e-12);
  }
}

TEST(ScaledMotion, CannotDistinguishALongerMotionFromALargerScale) {
  // Six directions of the world frame and this one are unobservable: an IMU or a known scale must
  // constrain it.
  std::mt19937 rng(125);
  const Pose T_i = RandomPose(rng), T_j = RandomPose(rng), Z = Seen(T_i, T_j, 0.9);
  const ScaledMotion f(Z, TestWeight(rng), kT_BC);
  Eigen::Matrix<double, 13, 1> direction = Eigen::Matrix<double, 13, 1>::Zero();
  direction.segment<3>(6) = (T_i * kT_BC).q() * Z.p();
  direction(12) = 1.0;
  const Eigen::MatrixXd J = TangentJacobian(f, {ToBlock(T_i), ToBlock(T_j), {0.9}}, kManifolds);
  EXPECT_LT((J * direction).norm(), 1e-12);
  EXPECT_EQ(Eigen::FullPivLU<Eigen::MatrixXd>(J).rank(), 6);
}

TEST(ScaledMotion, SolvingRecoversTheScaleOfKnownBodies) {
  std::mt19937 rng(126);
  FactorGraph graph;
  const Variable<double> scale = graph.AddVariable(1.0);
  const Variable<Pose> first = graph.AddVariable(Pose());
  graph.Fix(first);
  for (int i = 0; i < 5; ++i) {
    const Pose truth = RandomPose(rng);
    const Variable<Pose> body =
        graph.AddVariable(truth * Pose::FromTangent({0.1, 0, 0.1}, {0, 0, 0}));
    graph.AddFactor(
        std::make_unique<ScaledMotion>(Seen(Pose(), truth, 0.9615), Matrix6::Identity(), kT_BC),
        first, body, scale);
    graph.AddFactor(std::make_unique<RelativePose>(truth, Matrix6::Identity()), first, body);
  }
  ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0}).IsUsable());
  EXPECT_NEAR(graph.Value(scale), 0.9615, 1e-9);
}

TEST(ScaledMotion, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Pose broken;
  broken.data()[1] = nan;
  EXPECT_THROW(ScaledMotion(broken, Matrix6::Identity()), InvalidArgument);
  EXPECT_THROW(ScaledMotion(Pose(), Matrix6::Constant(nan)), InvalidArgument);
  EXPECT_THROW(ScaledMotion(Pose(), Matrix6::Identity(), broken), InvalidArgument);
}

TEST(ScaledMotion, FailsWhereAValueIsNotFinite) {
  const ScaledMotion f(Pose(), Matrix6::Identity());
  const Pose pose;
  for (const double scale : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    const double* blocks[] = {pose.data(), pose.data(), &scale};
    Vector6 r;
    EXPECT_FALSE(f.Evaluate(blocks, r.data(), nullptr));
  }
}

}  // namespace
}  // namespace highwall::scaled_motion_test
