#include <array>
#include <cmath>
#include <memory>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

#include "guarded_factor.h"
#include "landmark_problem.h"
#include "point_observation.h"
#include "random_states.h"
#include "variable_projection.h"

// LinearSolver::kCompactSchur, beside its cost function (variable_projection_test.cc).
namespace highwall::compact_schur_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

TEST(CompactSchur, DampsTheLandmarksOfTheFirstStep) {
  // A pose that a prior holds, and a landmark 1 m from where it is observed: the step of the
  // landmark is that of a Cholesky solver with the same damping of all variables. Beside one that
  // is observed in two places its error is small, so that it takes no other step.
  const auto move = [](LinearSolver solver, double radius) {
    FactorGraph graph;
    const auto pose = graph.AddVariable(Pose());
    graph.AddFactor(std::make_unique<PosePrior>(Pose(), 1e6 * Matrix6::Identity()), pose);
    const auto point = graph.AddLandmark(Point(0, 0, 2));
    graph.AddFactor(MakeObservation({1, 0, 2}), pose, point);
    const auto fixed = graph.AddVariable(Pose());
    graph.Fix(fixed);
    const auto doubtful = graph.AddLandmark(Point(0, 0, 2));
    for (const double x : {-100.0, 100.0}) {
      graph.AddFactor(MakeObservation({x, 0, 2}), fixed, doubtful);
    }
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

// Gauss-Newton steps from beyond 0.35 overshoot.
struct Saturating {
  template <class S>
  bool operator()(const S* unknown, const S* landmark, S* r) const {
    using std::atan;
    r[0] = atan(S(4.0) * (landmark[0] - unknown[0]));
    r[1] = landmark[1];
    r[2] = landmark[2];
    return true;
  }
};

TEST(CompactSchur, ALandmarkThatOvershootsIsDampedByItself) {
  const ceres::AutoDiffCostFunction<Saturating, 3, 1, 3> cost(new Saturating);
  double x = 0.0;
  std::array<double, 3> landmark{1.0, 0.0, 0.0};
  internal::LandmarkProblem problem;
  problem.unknowns = {{&x, 1, 1}};
  problem.landmarks = {{.block = {landmark.data(), 3, 3}, .first_factor = 0, .end_factor = 1}};
  problem.factors = {{.cost = &cost}};
  problem.arguments = {{.unknown = 0}, {}};
  internal::FactorFaults faults;
  internal::VariableProjection::Memory memory;
  const internal::VariableProjection projection(problem, 1e-4, &faults, &memory);
  // Returns the cost at x, accepted or tried.
  const auto evaluate = [&](bool accepted) {
    std::array<double, 2> r{}, J{};
    const double* const at = &x;
    double* to = J.data();
    EXPECT_TRUE(projection.Evaluate(&at, r.data(), accepted ? &to : nullptr));
    return r[0] * r[0] + r[1] * r[1];
  };
  const double before = evaluate(true);
  x += 2e-3;
  // With the damping of the first step, 1e-4, the landmark would overshoot in this trial, and in
  // all that Ceres tries after it: only 100 is enough.
  EXPECT_LT(evaluate(false), 0.9 * before);
}

TEST(CompactSchur, ALandmarkFarFromItsMinimumTakesStepsOfItsOwn) {
  // With the damping of the joint step alone the landmark would stay 1 / 3 m from its minimum.
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose());
  graph.AddFactor(std::make_unique<PosePrior>(Pose(), 1e6 * Matrix6::Identity()), pose);
  const auto point = graph.AddLandmark(Point(0, 0, 2));
  graph.AddFactor(MakeObservation({1, 0, 2}), pose, point);
  ASSERT_TRUE(graph
                  .Solve({.max_iterations = 1,
                          .initial_trust_region_radius = 2.0,
                          .linear_solver = LinearSolver::kCompactSchur})
                  .IsUsable());
  // Steps end where one is predicted to gain less than a thousandth of the cost at the start. From
  // a distance d a step with this damping gains d^2 / 1.5.
  EXPECT_NEAR(graph.Value(point).x(), 1.0, std::sqrt(1.5e-3));
}

}  // namespace
}  // namespace highwall::compact_schur_test
