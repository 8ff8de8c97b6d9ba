#include <highwall/core/prior.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>

#include "random_states.h"

namespace highwall::prior_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 Residual(const PosePrior& factor, const Pose& T) {
  const double* blocks[] = {T.data()};
  Vector6 r;
  EXPECT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  return r;
}

void ExpectJacobians(const PosePrior& factor, const Pose& T, const char* where) {
  const PoseManifold manifold;
  const auto result = testing::CheckJacobians(factor, {Block(T)}, {&manifold});
  EXPECT_TRUE(result) << where << ": " << result.message;
}

TEST(PosePrior, IsZeroAtTheExpectedPose) {
  RandomStates random(1);
  const Pose T = random.RandomPose();
  EXPECT_LT(Residual(PosePrior(T, Matrix6::Identity()), T).norm(), 1e-15);
}

TEST(PosePrior, IsTheWeightedDifferenceInTheTangentSpace) {
  const Pose T_0 = Pose::FromTangent({1, 2, 3}, {0, 0, 0.5});
  const Pose T = Pose::FromTangent({1.1, 2.2, 3.3}, {0, 0, 0.9});
  Vector6 w, expected;
  w << 1, 2, 3, 4, 5, 6;
  expected << 0.1, 0.4, 0.9, 0, 0, 2.4;
  EXPECT_TRUE(
      Residual(PosePrior(T_0, w.asDiagonal().toDenseMatrix()), T).isApprox(expected, 1e-14));
}

TEST(PosePrior, UndoesThePlusOfThePose) {
  RandomStates random(2);
  const Pose T_0 = random.RandomPose();
  Vector6 d;
  d << 0.3, -0.2, 0.1, 0.5, -1.0, 1.5;
  EXPECT_TRUE(Residual(PosePrior(T_0, Matrix6::Identity()), T_0.Plus(d)).isApprox(d, 1e-13));
}

TEST(PosePrior, JacobiansMatchCentralDifferences) {
  RandomStates random(3);
  for (int i = 0; i < 50; ++i) {
    const PosePrior factor(random.RandomPose(2.0, 1.5), random.Matrix<6>());
    ExpectJacobians(factor, random.RandomPose(2.0, 1.5), "random state");
  }
}

TEST(PosePrior, JacobiansMatchAtTinyAnglesAndNearPi) {
  RandomStates random(4);
  for (const double angle : {0.0, 1e-8, 1e-4, 0.01, std::numbers::pi - 1e-3}) {
    const Pose T_0 = random.RandomPose();
    Vector6 d;
    d << random.Vector(1.0), random.Direction() * angle;
    ExpectJacobians(PosePrior(T_0, random.Matrix<6>()), T_0.Plus(d), "edge angle");
  }
}

TEST(PosePrior, TheSignOfTheQuaternionChangesNothing) {
  RandomStates random(5);
  const PosePrior factor(random.RandomPose(), Matrix6::Identity());
  Pose T = random.RandomPose();
  const Vector6 r = Residual(factor, T);
  for (int i = 3; i < 7; ++i) T.data()[i] *= -1.0;
  EXPECT_TRUE(Residual(factor, T).isApprox(r, 1e-14));
}

TEST(PosePrior, ATurnedWorldTurnsThePositionPartOnly) {
  RandomStates random(6);
  const Pose T_0 = random.RandomPose(), T = random.RandomPose(), G = random.RandomPose();
  const Vector6 r = Residual(PosePrior(T_0, Matrix6::Identity()), T);
  const Vector6 moved = Residual(PosePrior(G * T_0, Matrix6::Identity()), G * T);
  EXPECT_TRUE(moved.head<3>().isApprox(G.R() * r.head<3>(), 1e-12));
  EXPECT_TRUE(moved.tail<3>().isApprox(r.tail<3>(), 1e-12));
}

TEST(PosePrior, SolvingRecoversTheExpectedPose) {
  RandomStates random(7);
  for (int i = 0; i < 10; ++i) {
    const Pose T_0 = random.RandomPose();
    FactorGraph graph;
    const auto pose = graph.AddVariable(random.RandomPose());
    graph.AddFactor(
        std::make_unique<PosePrior>(T_0, 2.0 * Matrix6::Identity() + 0.3 * random.Matrix<6>()),
        pose);
    ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
    EXPECT_LT((T_0.Inverse() * graph.Value(pose)).p().norm(), 1e-8);
    EXPECT_LT((T_0.Inverse() * graph.Value(pose)).Angle(), 1e-8);
  }
}

TEST(PosePrior, RefusesNonFiniteArguments) {
  Matrix6 W = Matrix6::Identity();
  W(1, 2) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(PosePrior(Pose(), W), InvalidArgument);
  Pose T;
  T.data()[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PosePrior(T, Matrix6::Identity()), InvalidArgument);
}

TEST(GravityPrior, IsTheSineOfTheTiltOverSigma) {
  const GravityPrior factor(0.1);
  for (const double angle : {0.0, 1e-8, 0.2, 1.5}) {
    const Pose tilted = Pose::FromTangent({1, 2, 3}, {0.6 * angle, 0.8 * angle, 0.0});
    const double* blocks[] = {tilted.data()};
    Eigen::Vector2d r;
    ASSERT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
    EXPECT_NEAR(r.norm(), std::sin(angle) / 0.1, 1e-14) << angle;
  }
}

TEST(GravityPrior, JacobiansMatchCentralDifferences) {
  RandomStates random(14);
  const PoseManifold manifold;
  for (int i = 0; i < 50; ++i) {
    const GravityPrior factor(random.Uniform(0.01, 1.0));
    const Pose T = random.RandomPose();
    const auto result = testing::CheckJacobians(
        factor, {std::vector<double>(T.data(), T.data() + Pose::kSize)}, {&manifold});
    EXPECT_TRUE(result) << result.message;
  }
}

TEST(GravityPrior, HeadingAndPositionAreFree) {
  const Pose turned = Pose::FromTangent({1e6, -5, 3}, {0.0, 0.0, 2.5});
  FactorGraph graph;
  const auto pose = graph.AddVariable(turned * Pose::FromTangent({0, 0, 0}, {0.3, -0.2, 0.0}));
  graph.AddFactor(std::make_unique<GravityPrior>(0.1), pose);
  ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
  const Pose level = graph.Value(pose);
  EXPECT_LT((level.q() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-8);
  EXPECT_LT((level.p() - turned.p()).norm(), 1e-9);
  // The prior aligns the pose by the smallest rotation, so the heading does not change.
  EXPECT_LT((turned.Inverse() * level).Angle(), 0.05);
}

TEST(GravityPrior, RefusesASigmaThatIsNotPositive) {
  EXPECT_THROW(GravityPrior(0.0), InvalidArgument);
  EXPECT_THROW(GravityPrior{std::numeric_limits<double>::quiet_NaN()}, InvalidArgument);
}

Eigen::Vector2d Residual(const DirectionPrior& factor, const UnitDirection& n) {
  const double* blocks[] = {n.data()};
  Eigen::Vector2d r;
  EXPECT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  return r;
}

TEST(DirectionPrior, IsTheSineOfTheAngleOverSigma) {
  const UnitDirection down;
  const DirectionPrior factor(down, 0.1);
  EXPECT_EQ(Residual(factor, down).norm(), 0.0);
  for (const double angle : {1e-8, 0.2, 1.5}) {
    for (const double turn : {0.0, 1.0, 2.5}) {
      const UnitDirection n(Eigen::Vector3d(std::sin(angle) * std::cos(turn),
                                            std::sin(angle) * std::sin(turn), -std::cos(angle)));
      EXPECT_NEAR(Residual(factor, n).norm(), std::sin(angle) / 0.1, 1e-14) << angle;
    }
  }
}

TEST(DirectionPrior, JacobiansMatchCentralDifferences) {
  RandomStates random(10);
  const UnitDirectionManifold manifold;
  for (int i = 0; i < 50; ++i) {
    const DirectionPrior factor(UnitDirection(random.Direction()), random.Uniform(0.01, 1.0));
    const Eigen::Vector3d n = random.Direction();
    const auto result = testing::CheckJacobians(factor, {{n.x(), n.y(), n.z()}}, {&manifold});
    EXPECT_TRUE(result) << result.message;
  }
}

TEST(DirectionPrior, TurningDirectionAndExpectationTogetherKeepsTheNorm) {
  RandomStates random(11);
  const Eigen::Vector3d n_0 = random.Direction(), n = random.Direction();
  const Eigen::Matrix3d R = random.RandomPose().R();
  const double norm = Residual(DirectionPrior(UnitDirection(n_0), 0.1), UnitDirection(n)).norm();
  const double turned =
      Residual(DirectionPrior(UnitDirection(R * n_0), 0.1), UnitDirection(R * n)).norm();
  EXPECT_NEAR(norm, turned, 1e-13);
}

TEST(DirectionPrior, SolvingRecoversTheExpectedDirection) {
  RandomStates random(12);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector3d n_0 = random.Direction();
    FactorGraph graph;
    // The pose is up to 60 degrees away.
    const auto n = graph.AddVariable(
        UnitDirection(Pose::FromTangent({0, 0, 0}, random.Vector(0.6)).R() * n_0));
    graph.AddFactor(std::make_unique<DirectionPrior>(UnitDirection(n_0), 0.1), n);
    ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
    EXPECT_LT((graph.Value(n).vector() - n_0).norm(), 1e-8);
  }
}

TEST(DirectionPrior, SigmaIsTheStandardDeviationInEitherTangent) {
  FactorGraph graph;
  const UnitDirection n_0(Eigen::Vector3d(1, 2, -3));
  const auto n = graph.AddVariable(n_0);
  graph.AddFactor(std::make_unique<DirectionPrior>(n_0, 0.1), n);
  EXPECT_LT((*graph.Covariance(n) - 0.01 * Eigen::Matrix2d::Identity()).norm(), 1e-14);
}

TEST(DirectionPrior, RefusesASigmaThatIsNotPositive) {
  for (const double sigma : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(DirectionPrior(UnitDirection(), sigma), InvalidArgument) << sigma;
  }
}

TEST(VectorPrior, IsTheWeightedDifference) {
  Eigen::Matrix2d W;
  W << 1, 2, 0, 3;
  const VectorPrior<2> factor({1, 2}, W);
  const double x[] = {2, 4};
  const double* blocks[] = {x};
  Eigen::Vector2d r;
  ASSERT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  EXPECT_EQ(r, Eigen::Vector2d(5, 6));
}

TEST(VectorPrior, JacobiansMatchCentralDifferences) {
  RandomStates random(8);
  for (int i = 0; i < 50; ++i) {
    const VectorPrior<3> factor(random.Vector(2.0), random.Matrix<3>());
    const Eigen::Vector3d x = random.Vector(2.0);
    const auto result = testing::CheckJacobians(factor, {{x.x(), x.y(), x.z()}}, {nullptr});
    EXPECT_TRUE(result) << result.message;
  }
}

TEST(VectorPrior, MovingVariableAndExpectationTogetherChangesNothing) {
  RandomStates random(9);
  const Eigen::Matrix3d W = random.Matrix<3>();
  const Eigen::Vector3d x_0 = random.Vector(1.0), x = random.Vector(1.0), shift(1, -2, 4);
  const Eigen::Vector3d moved = x + shift;
  const double* blocks[] = {x.data()};
  const double* moved_blocks[] = {moved.data()};
  Eigen::Vector3d r, r_moved;
  ASSERT_TRUE(VectorPrior<3>(x_0, W).Evaluate(blocks, r.data(), nullptr));
  ASSERT_TRUE(VectorPrior<3>(x_0 + shift, W).Evaluate(moved_blocks, r_moved.data(), nullptr));
  EXPECT_TRUE(r.isApprox(r_moved, 1e-13));
}

TEST(VectorPrior, SolvingFusesTwoPriorsByTheirInformation) {
  FactorGraph graph;
  using Scalar = Eigen::Matrix<double, 1, 1>;
  const auto x = graph.AddVariable(7.0);
  graph.AddFactor(std::make_unique<VectorPrior<1>>(Scalar(0.0), Scalar(1.0)), x);
  graph.AddFactor(std::make_unique<VectorPrior<1>>(Scalar(3.0), Scalar(2.0)), x);
  ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
  EXPECT_NEAR(graph.Value(x), 2.4, 1e-9);  // (1 * 0 + 4 * 3) / 5
}

TEST(VectorPrior, RefusesNonFiniteArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(VectorPrior<2>({nan, 0}, Eigen::Matrix2d::Identity()), InvalidArgument);
  EXPECT_THROW(VectorPrior<2>({0, 0}, Eigen::Matrix2d::Constant(nan)), InvalidArgument);
}

}  // namespace
}  // namespace highwall::prior_test
