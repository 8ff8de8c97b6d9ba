#include <highwall/factors/camera_pose.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/calibration_twins.h"
#include "support/imu_scene.h"

namespace highwall::camera_pose_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr, nullptr};

Matrix6 TestWeight(std::mt19937& rng) {
  Matrix6 W = 2.0 * Matrix6::Identity();
  for (double& w : W.reshaped()) w += Uniform(rng, -1.0, 1.0);
  return W;
}

TEST(CameraPose, MovesTheBodyToTheInstantOfTheImage) {
  // The camera is 0.5 m ahead of a body that moves along x at 2 m/s and rotates about z at 1 rad/s.
  const Pose T_BC = Pose::FromTangent({0.5, 0, 0}, {0, 0, 0});
  const CameraPose f(Pose(), Matrix6::Identity(), T_BC, {0, 0, 1}, 0.01);
  const auto at = [&](double t_d) {
    return Residual(f, {ToBlock(Pose::FromTangent({1, 0, 0}, {0, 0, 0})), {2, 0, 0}, {t_d}});
  };
  Vector6 expected;
  expected << 1.5, 0, 0, 0, 0, 0;
  EXPECT_LT((at(0.01) - expected).norm(), 1e-14);
  // 0.1 s later the body has moved by 0.2 m and rotated by 0.1 rad, and the camera with it.
  expected << 1.2 + 0.5 * std::cos(0.1), 0.5 * std::sin(0.1), 0, 0, 0, 0.1;
  EXPECT_LT((at(0.11) - expected).norm(), 1e-14);
}

TEST(CameraPose, WeighsTheErrorByTheSquareRootOfTheInformation) {
  std::mt19937 rng(90);
  const Matrix6 W = TestWeight(rng);
  const Pose T_0 = RandomPose(rng), T_BC = RandomPose(rng);
  const std::vector<Block> blocks = {ToBlock(RandomPose(rng)), {1, 2, 3}, {0.02}};
  const CameraPose plain(T_0, Matrix6::Identity(), T_BC, {0.1, 0.2, 0.3});
  const CameraPose weighted(T_0, W, T_BC, {0.1, 0.2, 0.3});
  EXPECT_LT((Residual(weighted, blocks) - W * Residual(plain, blocks)).norm(), 1e-12);
}

TEST(CameraPose, ADirectionWithoutInformationCostsNothing) {
  std::mt19937 rng(91);
  Matrix6 W = Matrix6::Identity();
  W(1, 1) = 0.0;  // y of the position is unobservable
  const Pose T_0 = Pose::FromTangent({1, 2, 3}, {0.1, 0.2, 0.3});
  const CameraPose f(T_0, W, Pose(), Eigen::Vector3d::Zero());
  const Pose T_WB(T_0.q(), T_0.p() + Eigen::Vector3d(0, 5, 0));
  EXPECT_LT(Residual(f, {ToBlock(T_WB), {1, 1, 1}, {0.0}}).norm(), 1e-14);
}

TEST(CameraPose, IsPosePriorWhereTheOffsetIsThatOfTheStateAndTheCameraIsTheBody) {
  std::mt19937 rng(92);
  for (int i = 0; i < 10; ++i) {
    const Pose T_0 = RandomPose(rng);
    const Matrix6 W = TestWeight(rng);
    const std::vector<Block> pose = {ToBlock(RandomPose(rng))};
    const CameraPose f(T_0, W, Pose(), RandomVector(rng, 1.0), -0.02);
    const PosePrior prior(T_0, W);
    const std::vector<Block> blocks = {pose[0], {1, 2, 3}, {-0.02}};
    EXPECT_LT((Residual(f, blocks) - Residual(prior, pose)).norm(), 1e-12);
    EXPECT_LT((TangentJacobian(f, blocks, kManifolds).leftCols<6>() -
               TangentJacobian(prior, pose, {&kPoseManifold}))
                  .norm(),
              1e-11);
  }
}

void CheckAt(std::mt19937& rng, const Pose& T_WB, const Vector6& error, double max_offset) {
  const Pose T_BC = RandomPose(rng);
  const Matrix6 W = TestWeight(rng);
  const Eigen::Vector3d omega_B = RandomVector(rng, 2.0), v_WB = RandomVector(rng, 2.0);
  const double d = Uniform(rng, -max_offset, max_offset);
  // The pose of the image deviates by `error` from that of the state.
  const Pose T_WB_d(T_WB.q() * so3::Exp(d * omega_B), T_WB.p() + d * v_WB);
  const Pose T_WC_0 = (T_WB_d * T_BC).Plus(error);
  const CameraPose f(T_WC_0, W, T_BC, omega_B, 0.01);
  const std::vector<Block> blocks = {ToBlock(T_WB), ToBlock(v_WB), {0.01 + d}};
  const auto check = testing::CheckJacobians(f, blocks, kManifolds);
  EXPECT_TRUE(check) << check.message;
  ExpectTwins(f, *twins::MakeCameraPose({T_WC_0, W, T_BC, omega_B, 0.01}), blocks, kManifolds,
              1e-10);
}

TEST(CameraPose, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(93);
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    Vector6 error;
    error << RandomVector(rng, 1.0), RandomVector(rng, 1.0);
    CheckAt(rng, RandomPose(rng), error, 0.1);
  }
}

TEST(CameraPose, JacobiansMatchAtTinyAnglesNearPiAndWithoutTurning) {
  std::mt19937 rng(94);
  for (const double angle : {1e-8, 1e-4, M_PI - 1e-3}) {
    SCOPED_TRACE(angle);
    Vector6 error;
    error << 0.1, 0.2, 0.3, angle * RandomVector(rng, 1.0).normalized();
    CheckAt(rng, RandomPose(rng), error, 0.1);
    CheckAt(rng, RandomPose(rng), error, 1e-9);
  }
  CheckAt(rng, Pose::FromTangent({1, 2, 3}, {M_PI, 0, 0}), Vector6::Constant(0.1), 0.1);
}

TEST(CameraPose, AMovedWorldTurnsThePositionRowsOnly) {
  std::mt19937 rng(95);
  const Pose T_WB = RandomPose(rng), T_NW = RandomPose(rng), T_0 = RandomPose(rng);
  const Pose T_BC = RandomPose(rng);
  const Eigen::Vector3d v_WB(1, -2, 0.5), omega_B(0.3, 0.2, -0.4);
  const CameraPose f(T_0, Matrix6::Identity(), T_BC, omega_B);
  const CameraPose moved(T_NW * T_0, Matrix6::Identity(), T_BC, omega_B);
  const Eigen::VectorXd r = Residual(f, {ToBlock(T_WB), ToBlock(v_WB), {0.03}});
  const Eigen::Vector3d v_NB = T_NW.q() * v_WB;
  const Eigen::VectorXd r_moved = Residual(moved, {ToBlock(T_NW * T_WB), ToBlock(v_NB), {0.03}});
  EXPECT_LT((r_moved.head<3>() - T_NW.q() * Eigen::Vector3d(r.head<3>())).norm(), 1e-12);
  EXPECT_LT((r_moved.tail<3>() - r.tail<3>()).norm(), 1e-12);
}

TEST(CameraPose, SolvesForTheOffsetOfAMovingBody) {
  // The images are taken 30 ms later than their stamps, and the states are known in the IMU's time.
  constexpr double kOffset = 0.03;
  std::mt19937 rng(96);
  const Pose T_BC = RandomPose(rng);
  const SinusoidalMotion motion;
  FactorGraph graph;
  const Variable<double> t_d = graph.AddVariable(0.0);
  for (int k = 0; k < 30; ++k) {
    const double t = 0.1 * k;
    const ImuState state = motion.StateAt(t);
    const auto pose = graph.AddVariable(state.T_WB);
    const auto velocity = graph.AddVariable(state.v_WB);
    graph.Fix(pose);
    graph.Fix(velocity);
    graph.AddFactor(std::make_unique<CameraPose>(motion.StateAt(t + kOffset).T_WB * T_BC,
                                                 Matrix6(1e3 * Matrix6::Identity()), T_BC,
                                                 motion.SampleAt(FromSeconds(t)).gyroscope),
                    pose, velocity, t_d);
  }
  ASSERT_TRUE(graph.Solve().IsUsable());
  // Velocity and rate are assumed constant: the error is half the acceleration times (30 ms)^2, 2
  // mm of 50, of either sign, and averages out.
  EXPECT_NEAR(graph.Value(t_d), kOffset, 3e-4);
}

TEST(CameraPose, SolvingRecoversTheBodyFromTheCamera) {
  std::mt19937 rng(97);
  for (int i = 0; i < 10; ++i) {
    const Pose T_WB = RandomPose(rng), T_BC = RandomPose(rng);
    FactorGraph graph;
    Vector6 away;
    away << RandomVector(rng, 0.5), RandomVector(rng, 0.5);
    const auto pose = graph.AddVariable(T_WB.Plus(away));
    const auto velocity = graph.AddVariable(Eigen::Vector3d(1, 2, 3));
    const auto t_d = graph.AddVariable(0.02);
    graph.Fix(velocity);
    graph.Fix(t_d);
    graph.AddFactor(std::make_unique<CameraPose>(T_WB * T_BC, TestWeight(rng), T_BC,
                                                 Eigen::Vector3d(0.1, 0.2, 0.3), 0.02),
                    pose, velocity, t_d);
    ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
    EXPECT_LT((graph.Value(pose).p() - T_WB.p()).norm(), 1e-8);
    EXPECT_LT((graph.Value(pose).Inverse() * T_WB).Angle(), 1e-8);
  }
}

TEST(CameraPose, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Matrix6 W = Matrix6::Identity();
  const Eigen::Vector3d omega = Eigen::Vector3d::Zero();
  Pose bad;
  bad.data()[0] = nan;
  EXPECT_THROW(CameraPose(bad, W, Pose(), omega), InvalidArgument);
  EXPECT_THROW(CameraPose(Pose(), nan * W, Pose(), omega), InvalidArgument);
  EXPECT_THROW(CameraPose(Pose(), W, bad, omega), InvalidArgument);
  EXPECT_THROW(CameraPose(Pose(), W, Pose(), {nan, 0, 0}), InvalidArgument);
  EXPECT_THROW(CameraPose(Pose(), W, Pose(), omega, nan), InvalidArgument);
}

TEST(CameraPose, FailsWhereAValueIsNotFinite) {
  const CameraPose f(Pose(), Matrix6::Identity(), Pose(), Eigen::Vector3d::Zero());
  const Block pose = ToBlock(Pose());
  const double velocity[] = {HUGE_VAL, 0, 0}, t_d[] = {0.1};
  const double* parameters[] = {pose.data(), velocity, t_d};
  Vector6 r;
  EXPECT_FALSE(f.Evaluate(parameters, r.data(), nullptr));
}

}  // namespace
}  // namespace highwall::camera_pose_test
