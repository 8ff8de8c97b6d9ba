#include <highwall/core/relative_pose.h>

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/internal/se3.h>

#include "random_states.h"

namespace highwall::relative_pose_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 Residual(const RelativePose& factor, const Pose& T_i, const Pose& T_j) {
  const double* blocks[] = {T_i.data(), T_j.data()};
  Vector6 r;
  EXPECT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  return r;
}

void ExpectJacobians(const RelativePose& factor, const Pose& T_i, const Pose& T_j,
                     const char* where) {
  const PoseManifold manifold;
  const auto result =
      testing::CheckJacobians(factor, {Block(T_i), Block(T_j)}, {&manifold, &manifold});
  EXPECT_TRUE(result) << where << ": " << result.message;
}

TEST(RelativePose, IsZeroWhereTheMeasurementHolds) {
  RandomStates random(1);
  const Pose T_i = random.RandomPose(), T_j = random.RandomPose();
  const RelativePose factor(T_i.Inverse() * T_j, Matrix6::Identity());
  EXPECT_LT(Residual(factor, T_i, T_j).norm(), 1e-14);
}

TEST(RelativePose, OfAQuarterTurnComputedByHand) {
  // Exp of a rotation by pi/2 about z along rho = (pi/2, 0, 0) is a quarter circle of radius 1 that
  // ends at (1, 1, 0).
  const double quarter = 0.5 * std::numbers::pi;
  const Pose T_j = Pose::FromTangent({1, 1, 0}, {0, 0, quarter});
  Vector6 expected;
  expected << quarter, 0, 0, 0, 0, quarter;
  EXPECT_TRUE(
      Residual(RelativePose(Pose(), Matrix6::Identity()), Pose(), T_j).isApprox(expected, 1e-14));
  Vector6 w;
  w << 1, 2, 3, 4, 5, 6;
  expected << quarter, 0, 0, 0, 0, 6.0 * quarter;
  EXPECT_TRUE(Residual(RelativePose(Pose(), w.asDiagonal().toDenseMatrix()), Pose(), T_j)
                  .isApprox(expected, 1e-14));
}

TEST(RelativePose, JacobiansMatchCentralDifferences) {
  RandomStates random(2);
  for (int i = 0; i < 50; ++i) {
    const Pose Z = random.RandomPose(), T_i = random.RandomPose();
    const Pose E = random.RandomPose(2.0, 2.5);  // away from the optimum and from the jump at pi
    ExpectJacobians(RelativePose(Z, random.Matrix<6>()), T_i, T_i * Z * E, "random state");
  }
}

TEST(RelativePose, JacobiansMatchAtTinyAnglesAndNearPi) {
  RandomStates random(3);
  for (const double angle :
       {0.0, 1e-8, 1e-4, 0.0099, 0.0101, 0.0999, 0.1001, std::numbers::pi - 1e-3}) {
    const Pose Z = random.RandomPose(), T_i = random.RandomPose();
    const Pose E = Pose::FromTangent(random.Vector(1.0), random.Direction() * angle);
    ExpectJacobians(RelativePose(Z, random.Matrix<6>()), T_i, T_i * Z * E, "edge angle");
  }
}

TEST(RelativePose, DoesNotChangeWhenTheWorldFrameMoves) {
  RandomStates random(4);
  const RelativePose factor(random.RandomPose(), random.Matrix<6>());
  for (int i = 0; i < 10; ++i) {
    const Pose T_i = random.RandomPose(), T_j = random.RandomPose(), G = random.RandomPose(100.0);
    // A translation of 100 m costs two digits.
    EXPECT_TRUE(Residual(factor, G * T_i, G * T_j).isApprox(Residual(factor, T_i, T_j), 1e-11));
  }
}

TEST(RelativePose, SwappingTheEndsAndInvertingTheMeasurementNegatesTheLogOfTheInverse) {
  RandomStates random(5);
  const Pose Z = random.RandomPose(), T_i = random.RandomPose();
  const Pose T_j = T_i * Z;
  const Pose E = Pose::FromTangent({0.1, 0.2, -0.1}, {0.3, -0.2, 0.1});
  const Vector6 forward = Residual(RelativePose(Z, Matrix6::Identity()), T_i, T_j * E);
  EXPECT_TRUE(forward.isApprox(se3::Log(E), 1e-12));
  const Vector6 backward = Residual(RelativePose(Z.Inverse(), Matrix6::Identity()), T_j * E, T_i);
  EXPECT_NEAR(backward.tail<3>().norm(), forward.tail<3>().norm(), 1e-12);
}

TEST(RelativePose, SolvingAClosedLoopRecoversTheTruth) {
  RandomStates random(6);
  std::vector<Pose> truth;
  for (int i = 0; i < 6; ++i) truth.push_back(random.RandomPose());
  FactorGraph graph;
  std::vector<Variable<Pose>> ids;
  for (const Pose& T : truth) {
    Vector6 d;
    d << random.Vector(0.2), random.Vector(0.2);
    ids.push_back(graph.AddVariable(T.Plus(d)));
  }
  graph.AddFactor(std::make_unique<PosePrior>(truth[0], Matrix6::Identity()), ids[0]);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::size_t j = (i + 1) % truth.size();
    graph.AddFactor(std::make_unique<RelativePose>(truth[i].Inverse() * truth[j],
                                                   3.0 * Matrix6::Identity() + random.Matrix<6>()),
                    ids[i], ids[j]);
  }
  ASSERT_TRUE(graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14}).IsUsable());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose error = truth[i].Inverse() * graph.Value(ids[i]);
    EXPECT_LT(error.p().norm(), 1e-8);
    EXPECT_LT(error.Angle(), 1e-8);
  }
}

TEST(RelativePose, ReturnsFalseInsteadOfThrowingOnNonFiniteStates) {
  const RelativePose factor(Pose(), Matrix6::Identity());
  Pose broken;
  broken.data()[1] = std::numeric_limits<double>::quiet_NaN();
  const Pose good;
  const double* blocks[] = {broken.data(), good.data()};
  Vector6 r;
  EXPECT_FALSE(factor.Evaluate(blocks, r.data(), nullptr));
}

TEST(RelativePose, RefusesNonFiniteArguments) {
  Pose Z;
  Z.data()[0] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(RelativePose(Z, Matrix6::Identity()), InvalidArgument);
  EXPECT_THROW(RelativePose(Pose(), Matrix6::Constant(std::numeric_limits<double>::quiet_NaN())),
               InvalidArgument);
}

}  // namespace
}  // namespace highwall::relative_pose_test
