#include <highwall/factors/white_acceleration.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"

namespace highwall::white_acceleration_test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr AccelerationNoise kNoise{.linear = 0.5, .angular = 2.0};

struct State {
  Pose T;
  Vector6 u = Vector6::Zero();
};

Eigen::Matrix<double, 12, 1> ResidualOf(const WhiteAcceleration& factor, const State& i,
                                        const State& j) {
  const double* blocks[] = {i.T.data(), i.u.data(), j.T.data(), j.u.data()};
  Eigen::Matrix<double, 12, 1> r;
  EXPECT_TRUE(factor.Evaluate(blocks, r.data(), nullptr));
  return r;
}

Vector6 RandomVelocities(std::mt19937& rng) {
  Vector6 u;
  u << RandomVector(rng, 2.0), RandomVector(rng, 3.0);
  return u;
}

Block BlockOf(const Pose& T) {
  return {T.data(), T.data() + 7};
}

Block BlockOf(const Vector6& u) {
  return {u.data(), u.data() + 6};
}

// The state after dt at constant velocities.
State After(const State& state, double dt) {
  State after = state;
  after.T = Pose(state.T.q() * so3::Exp(dt * Eigen::Vector3d(state.u.tail<3>())),
                 state.T.p() + dt * state.u.head<3>());
  return after;
}

TEST(WhiteAcceleration, IsZeroAtConstantVelocities) {
  std::mt19937 rng(1);
  for (int i = 0; i < 20; ++i) {
    const State state{Pose::FromTangent(RandomVector(rng, 5.0), RandomVector(rng, 1.5)),
                      RandomVelocities(rng)};
    const WhiteAcceleration factor(0.1, kNoise);
    // Rounding of 1e-15 in units of a standard deviation of 0.1^1.5 sqrt(0.5 / 12).
    EXPECT_LT(ResidualOf(factor, state, After(state, 0.1)).norm(), 1e-11);
  }
}

TEST(WhiteAcceleration, SquaredResidualIsThatOfTheCovarianceOfIntegratedNoise) {
  // Eq. 2: Q = q [dt^3/3, dt^2/2; dt^2/2, dt] of one axis.
  const double dt = 0.2;
  const WhiteAcceleration factor(dt, kNoise);
  for (const bool angular : {false, true}) {
    const double q = angular ? kNoise.angular : kNoise.linear;
    Eigen::Matrix2d Q;
    Q << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
    const Eigen::Vector2d e(0.03, -0.1);
    State j;
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), theta = p;
    (angular ? theta : p).y() = e(0);
    j.T = Pose::FromTangent(p, theta);
    j.u(angular ? 4 : 1) = e(1);
    EXPECT_NEAR(ResidualOf(factor, State(), j).squaredNorm(), e.dot((q * Q).inverse() * e), 1e-10);
  }
}

TEST(WhiteAcceleration, JacobiansMatchCentralDifferences) {
  std::mt19937 rng(2);
  const PoseManifold manifold;
  for (const double angle : {0.0, 1e-8, 1e-4, 0.0101, 0.5, 2.0, std::numbers::pi - 1e-2}) {
    for (int i = 0; i < 10; ++i) {
      const Pose T_i = Pose::FromTangent(RandomVector(rng, 5.0), RandomVector(rng, 1.5));
      const Pose T_j(T_i.q() * so3::Exp(angle * RandomVector(rng, 1.0).normalized()),
                     RandomVector(rng, 5.0));
      const WhiteAcceleration factor(Uniform(rng, 0.2, 2.0), kNoise);
      const auto check = testing::CheckJacobians(factor,
                                                 {BlockOf(T_i), BlockOf(RandomVelocities(rng)),
                                                  BlockOf(T_j), BlockOf(RandomVelocities(rng))},
                                                 {&manifold, nullptr, &manifold, nullptr});
      EXPECT_TRUE(check) << angle << ": " << check.message;
    }
  }
}

TEST(WhiteAcceleration, KeepsItsLengthWhenTheWorldMoves) {
  std::mt19937 rng(3);
  const WhiteAcceleration factor(0.3, kNoise);
  const Pose T = Pose::FromTangent({1, -2, 3}, {0.3, -0.5, 1.0});
  State i{Pose::FromTangent({0.1, 0.2, 0.3}, {0.2, 0.1, -0.4}), RandomVelocities(rng)};
  State j{Pose::FromTangent({0.4, 0.1, 0.2}, {0.1, 0.3, -0.2}), RandomVelocities(rng)};
  const double before = ResidualOf(factor, i, j).norm();
  for (State* state : {&i, &j}) {
    state->T = T * state->T;
    state->u.head<3>() = T.q() * state->u.head<3>();
  }
  EXPECT_NEAR(ResidualOf(factor, i, j).norm(), before, 1e-10);
}

TEST(WhiteAcceleration, APoseBetweenTwoKnownOnesIsTheCubicThroughThem) {
  // The mean of integrated white noise between two known states is the cubic Hermite spline.
  FactorGraph graph;
  const Vector6 at_rest = Vector6::Zero();
  const Pose end = Pose::FromTangent({1, 2, -1}, {0.2, 0, 0});
  const auto T_0 = graph.AddVariable(Pose()), T_1 = graph.AddVariable(Pose()),
             T_2 = graph.AddVariable(end);
  const auto u_0 = graph.AddVariable(at_rest), u_1 = graph.AddVariable(at_rest),
             u_2 = graph.AddVariable(at_rest);
  for (const VariableId& known : std::vector<VariableId>{T_0, u_0, T_2, u_2}) graph.Fix(known);
  graph.AddFactor(std::make_unique<WhiteAcceleration>(0.25, kNoise), T_0, u_0, T_1, u_1);
  graph.AddFactor(std::make_unique<WhiteAcceleration>(0.75, kNoise), T_1, u_1, T_2, u_2);
  SolveOptions options;
  options.function_tolerance = 1e-16;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  const double share = 3 * 0.0625 - 2 * 0.015625;  // 3 s^2 - 2 s^3 at s = 1/4
  EXPECT_LT((graph.Value(T_1).p() - share * end.p()).norm(), 1e-9);
  EXPECT_NEAR(so3::Log(graph.Value(T_1).q()).x(), share * 0.2, 1e-9);
  const double rate = 6 * 0.25 - 6 * 0.0625;  // its derivative
  EXPECT_LT((graph.Value(u_1).head<3>() - rate * end.p()).norm(), 1e-8);
}

TEST(WhiteAcceleration, ReturnsFalseWhereAStateIsNotFinite) {
  const WhiteAcceleration factor(0.1, kNoise);
  State i, j;
  j.u(2) = std::numeric_limits<double>::quiet_NaN();
  const double* blocks[] = {i.T.data(), i.u.data(), j.T.data(), j.u.data()};
  Eigen::Matrix<double, 12, 1> r;
  EXPECT_FALSE(factor.Evaluate(blocks, r.data(), nullptr));
}

TEST(WhiteAcceleration, RefusesBadArguments) {
  EXPECT_THROW(WhiteAcceleration(0.0, kNoise), InvalidArgument);
  EXPECT_THROW(WhiteAcceleration(0.1, {.linear = -1.0}), InvalidArgument);
  EXPECT_THROW(WhiteAcceleration(0.1, {.angular = 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::white_acceleration_test
