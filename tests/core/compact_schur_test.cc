#include <cmath>
#include <memory>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

#include "point_observation.h"
#include "random_states.h"

// LinearSolver::kCompactSchur, beside its cost function (variable_projection_test.cc).
namespace highwall::compact_schur_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

TEST(CompactSchur, DampsTheLandmarksOfTheFirstStep) {
  // A pose that a prior holds, and a landmark 1 m from where it is observed: the step of the
  // landmark is that of a Cholesky solver with the same damping of all variables.
  const auto move = [](LinearSolver solver, double radius) {
    FactorGraph graph;
    const auto pose = graph.AddVariable(Pose());
    graph.AddFactor(std::make_unique<PosePrior>(Pose(), 1e6 * Matrix6::Identity()), pose);
    const auto point = graph.AddLandmark(Point(0, 0, 2));
    graph.AddFactor(MakeObservation({1, 0, 2}), pose, point);
    EXPECT_TRUE(graph
                    .Solve({.max_iterations = 1,
                            .initial_trust_region_radius = radius,
                            .linear_solver = solver})
                    .IsUsable());
    return graph.Value(point).x();
  };
  for (const double radius : {2.0, 10.0, 1e4}) {
    const double x = move(LinearSolver::kCompactSchur, radius);
    EXPECT_NEAR(x, 1.0 / (1.0 + 1.0 / radius), 1e-6);  // the pose yields by 1e-12
    EXPECT_NEAR(x, move(LinearSolver::kDenseCholesky, radius), 1e-6);
  }
}

// Poses that are known do not move, and so the stopping rules of Ceres are met at once.
TEST(CompactSchur, EndsWhereTheLandmarksAreAtTheirMinimum) {
  const auto solve = [](LinearSolver solver, int iterations) {
    FactorGraph graph;
    const auto fixed = graph.AddVariable(Pose());
    graph.Fix(fixed);
    const Pose truth = Pose::FromTangent({0.3, 0.0, 0.0}, {0.0, 0.1, 0.0});
    const auto known = graph.AddVariable(truth);
    graph.AddFactor(std::make_unique<PosePrior>(truth, 1e6 * Matrix6::Identity()), known);
    RandomStates random(5);
    const auto loss = std::make_shared<ceres::HuberLoss>(0.05);
    for (int i = 0; i < 10; ++i) {
      const Point x = random.Vector(4.0);
      const auto point = graph.AddLandmark(Point(x + random.Vector(i < 3 ? 3.0 : 0.01)));
      graph.AddFactor(MakeObservation(x), loss, fixed, point);
      graph.AddFactor(MakeObservation(truth.Inverse() * x), loss, known, point);
    }
    SolveOptions options{.max_iterations = iterations, .linear_solver = solver};
    return graph.Solve(options);
  };
  const SolveSummary summary = solve(LinearSolver::kCompactSchur, 100);
  EXPECT_EQ(summary.status, SolveStatus::kConverged);
  EXPECT_GT(summary.initial_cost, 0.1);
  EXPECT_LT(summary.final_cost, 1e-6 * summary.initial_cost);
  EXPECT_LE(summary.iterations, 100);
  // No more iterations than requested, and no convergence that was not reached.
  const SolveSummary limited = solve(LinearSolver::kCompactSchur, 1);
  EXPECT_EQ(limited.status, SolveStatus::kLimit) << limited.message;
  EXPECT_LE(limited.iterations, 2);
}

// Saturates along x, so that a Gauss-Newton step from beyond 0.35 m overshoots, farther each time.
struct SaturatingObservation {
  template <class S>
  bool operator()(const S* pose, const S* x, S* r) const {
    using std::atan;
    const Eigen::Map<const Eigen::Matrix<S, 3, 1>> p(pose), point(x);
    r[0] = atan(S(4.0) * (point[0] - p[0]));
    r[1] = point[1] - p[1];
    r[2] = point[2] - p[2];
    return true;
  }
};

TEST(CompactSchur, ALandmarkThatOvershootsIsDampedByItself) {
  RandomStates random(9);
  FactorGraph graph;
  const auto pose = graph.AddVariable(random.RandomPose(0.1, 0.1));
  for (int i = 0; i < 20; ++i) {
    const Point x = random.Vector(4.0);
    const auto point = graph.AddLandmark(Point(x + random.Vector(0.1)));
    graph.AddFactor(MakeObservation(x), pose, point);
    graph.AddFactor(std::make_unique<VectorPrior<3>>(x, Eigen::Matrix3d::Identity()), point);
  }
  const auto far = graph.AddLandmark(Point(1.0, 0.5, -0.5));
  graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<SaturatingObservation, 3, 7, 3>>(
                      new SaturatingObservation),
                  pose, far);
  const SolveSummary summary =
      graph.Solve({.max_iterations = 30, .linear_solver = LinearSolver::kCompactSchur});
  EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  // 8: the damping grows to 100 and then follows the curvature. With the same damping for all
  // landmarks every second step fails, and this one never moves.
  EXPECT_LE(summary.rejected_steps, 10);
  EXPECT_LT((graph.Value(far) - graph.Value(pose).p()).norm(), 1e-3);
}

}  // namespace
}  // namespace highwall::compact_schur_test
