#include <highwall/core/factor_graph.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/line3.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

#include "point_observation.h"
#include "random_states.h"
#include "support/message_of.h"

namespace highwall::factor_graph_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

std::unique_ptr<VectorPrior<1>> MakeScalarPrior(double x_0, double w = 1.0) {
  using Scalar = Eigen::Matrix<double, 1, 1>;
  return std::make_unique<VectorPrior<1>>(Scalar(x_0), Scalar(w));
}

TEST(FactorGraph, ValuesComeBackAsTheyWereForEveryKindOfVariable) {
  FactorGraph graph;
  const Pose T = Pose::FromTangent({1, 2, 3}, {0.1, 0.2, 0.3});
  const OrthonormalLine line(PluckerLine::FromPoints({1, 0, 0}, {1, 2, 0.5}));
  const Segment3 segment({1, 2, 3}, {4, 5, 6});
  const Eigen::Matrix<double, 6, 1> bias = Eigen::Matrix<double, 6, 1>::LinSpaced(0.1, 0.6);
  const auto pose_id = graph.AddVariable(T);
  const auto line_id = graph.AddVariable(line);
  const auto segment_id = graph.AddVariable(segment);
  const auto point_id = graph.AddVariable(Point(7, 8, 9));
  const auto bias_id = graph.AddVariable(bias);
  const auto scalar_id = graph.AddVariable(0.25);
  EXPECT_EQ(Block(graph.Value(pose_id)), Block(T));
  EXPECT_EQ(graph.Value(line_id).Plucker().n, line.Plucker().n);
  EXPECT_EQ(graph.Value(segment_id).q(), segment.q());
  EXPECT_EQ(graph.Value(point_id), Point(7, 8, 9));
  EXPECT_EQ(graph.Value(bias_id), bias);
  EXPECT_EQ(graph.Value(scalar_id), 0.25);
  EXPECT_EQ(graph.NumVariables(), 6u);
  EXPECT_EQ(graph.problem().ParameterBlockTangentSize(graph.Block(pose_id)), 6);
  EXPECT_EQ(graph.problem().ParameterBlockTangentSize(graph.Block(line_id)), 4);
  EXPECT_EQ(graph.problem().ParameterBlockTangentSize(graph.Block(segment_id)), 6);

  graph.SetValue(point_id, Point(-1, 0, 1));
  EXPECT_EQ(graph.Value(point_id), Point(-1, 0, 1));
}

TEST(FactorGraph, BlocksKeepTheirAddressWhileOthersComeAndGo) {
  FactorGraph graph;
  const auto kept = graph.AddVariable(1.5);
  const double* block = graph.Block(kept);
  std::vector<Variable<double>> others;
  for (int i = 0; i < 1000; ++i) others.push_back(graph.AddVariable(0.5 * i));
  for (const auto& other : others) graph.Remove(other);
  FactorGraph moved = std::move(graph);
  EXPECT_EQ(moved.Block(kept), block);
  EXPECT_EQ(moved.Value(kept), 1.5);
  EXPECT_EQ(moved.FindVariable(block), kept);
}

TEST(FactorGraph, SolvesAPoseAgainstKnownPointsWithAUsersAutoDiffCost) {
  RandomStates random(1);
  FactorGraph graph;
  const Pose truth = random.RandomPose();
  const auto pose = graph.AddVariable(truth.Plus({0.3, -0.2, 0.1, 0.2, -0.3, 0.2}));
  for (int i = 0; i < 5; ++i) {
    const Point x = random.Vector(3.0);
    const auto point = graph.AddVariable(x);
    graph.Fix(point);
    EXPECT_TRUE(graph.IsFixed(point));
    graph.AddFactor(MakeObservation(truth.Inverse() * x), pose, point);
  }
  const SolveSummary summary =
      graph.Solve({.function_tolerance = 0.0, .parameter_tolerance = 1e-14});
  EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  EXPECT_TRUE(summary.IsUsable());
  EXPECT_GT(summary.initial_cost, 0.1);
  EXPECT_LT(summary.final_cost, 1e-18);
  EXPECT_GE(summary.iterations, 2);
  // Quadratic convergence on consistent data: exact to rounding.
  EXPECT_LT((truth.Inverse() * graph.Value(pose)).p().norm(), 1e-9);
  EXPECT_LT((truth.Inverse() * graph.Value(pose)).Angle(), 1e-9);
}

TEST(FactorGraph, EveryLinearSolverFindsTheSameBundle) {
  RandomStates random(2);
  std::vector<Pose> poses;
  std::vector<Point> points;
  for (int i = 0; i < 4; ++i) poses.push_back(random.RandomPose(1.0, 0.5));
  for (int i = 0; i < 12; ++i) points.push_back(random.Vector(4.0));
  for (const LinearSolver solver :
       {LinearSolver::kAuto, LinearSolver::kDenseCholesky, LinearSolver::kSparseCholesky,
        LinearSolver::kDenseSchur, LinearSolver::kSparseSchur, LinearSolver::kCompactSchur,
        LinearSolver::kVariableProjection}) {
    RandomStates noise(3);
    FactorGraph graph;
    std::vector<Variable<Pose>> pose_ids;
    std::vector<Variable<Point>> point_ids;
    for (const Pose& T : poses) {
      const bool first = pose_ids.empty();
      const Eigen::Vector3d dp = noise.Vector(0.05), dtheta = noise.Vector(0.05);
      Eigen::Matrix<double, 6, 1> d;
      d << dp, dtheta;
      pose_ids.push_back(graph.AddVariable(first ? T : T.Plus(d)));
    }
    graph.Fix(pose_ids[0]);
    for (const Point& x : points)
      point_ids.push_back(graph.AddLandmark(Point(x + noise.Vector(0.1))));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (std::size_t j = 0; j < points.size(); ++j) {
        graph.AddFactor(MakeObservation(poses[i].Inverse() * points[j]), pose_ids[i], point_ids[j]);
      }
    }
    const SolveSummary summary =
        graph.Solve({.function_tolerance = 1e-16, .linear_solver = solver});
    ASSERT_TRUE(summary.IsUsable()) << summary.message;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_LT((poses[i].Inverse() * graph.Value(pose_ids[i])).p().norm(), 1e-8);
    }
    for (std::size_t j = 0; j < points.size(); ++j) {
      EXPECT_LT((graph.Value(point_ids[j]) - points[j]).norm(), 1e-8);
    }
  }
}

TEST(FactorGraph, EveryLinearSolverSolvesWithoutLandmarks) {
  for (const LinearSolver solver :
       {LinearSolver::kDenseSchur, LinearSolver::kSparseSchur, LinearSolver::kCompactSchur,
        LinearSolver::kVariableProjection}) {
    FactorGraph graph;
    const auto pose = graph.AddVariable(Pose::FromTangent({0.3, 0, 0}, {0, 0.2, 0}));
    graph.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), pose);
    EXPECT_EQ(graph.Solve({.linear_solver = solver}).status, SolveStatus::kConverged);
    EXPECT_LT(graph.Value(pose).p().norm(), 1e-6);
  }
}

TEST(FactorGraph, SchurSurvivesFixedLandmarks) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose::FromTangent({0.1, 0, 0}, {0, 0.1, 0}));
  RandomStates random(4);
  for (int i = 0; i < 4; ++i) {
    const Point x = random.Vector(2.0);
    const auto point = graph.AddLandmark(x);
    graph.Fix(point);
    graph.AddFactor(MakeObservation(x), pose, point);
  }
  const SolveSummary summary = graph.Solve({.linear_solver = LinearSolver::kSparseSchur});
  EXPECT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_LT(graph.Value(pose).p().norm(), 1e-6);
}

TEST(FactorGraph, AFactorBetweenTwoLandmarksFailsWithAMessage) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose());
  const auto a = graph.AddLandmark(Pose()), b = graph.AddLandmark(Pose());
  graph.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), pose);
  graph.AddFactor(std::make_unique<RelativePose>(Pose(), Matrix6::Identity()), pose, a);
  graph.AddFactor(std::make_unique<RelativePose>(Pose(), Matrix6::Identity()), a, b);
  for (const LinearSolver solver :
       {LinearSolver::kAuto, LinearSolver::kCompactSchur, LinearSolver::kVariableProjection}) {
    const SolveSummary summary = graph.Solve({.linear_solver = solver});
    EXPECT_EQ(summary.status, SolveStatus::kFailed);
    EXPECT_FALSE(summary.IsUsable());
    EXPECT_NE(summary.message.find("independent set"), std::string::npos) << summary.message;
  }
}

TEST(FactorGraph, RefusesMismatchedBlocksBeforeCeresSeesThem) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose());
  const auto point = graph.AddVariable(Point(0, 0, 1));
  const auto other = graph.AddVariable(Pose());
  EXPECT_THROW(graph.AddFactor(MakeObservation({0, 0, 0}), pose), InvalidArgument);
  EXPECT_THROW(graph.AddFactor(MakeObservation({0, 0, 0}), pose, point, point), InvalidArgument);
  EXPECT_THROW(graph.AddFactor(MakeObservation({0, 0, 0}), point, pose), InvalidArgument);
  EXPECT_THROW(graph.AddFactor(std::unique_ptr<ceres::CostFunction>(), pose), InvalidArgument);
  EXPECT_THROW(
      graph.AddFactor(std::make_unique<RelativePose>(Pose(), Matrix6::Identity()), other, other),
      InvalidArgument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(graph.AddVariable(nan), InvalidArgument);
  EXPECT_THROW(graph.SetValue(point, Point(0, nan, 0)), InvalidArgument);
  EXPECT_THROW(graph.Solve({.max_iterations = -1}), InvalidArgument);
  EXPECT_THROW(graph.Solve({.threads = 0}), InvalidArgument);
  EXPECT_EQ(graph.NumFactors(), 0u);
  EXPECT_EQ(graph.NumVariables(), 3u);
}

TEST(SolveOptions, ErrorsNameTheField) {
  const auto expect_error = [](const SolveOptions& options, const std::string& field) {
    try {
      options.Validate();
      ADD_FAILURE() << field;
    } catch (const InvalidArgument& e) {
      EXPECT_NE(std::string(e.what()).find("::" + field), std::string::npos) << e.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_NO_THROW(SolveOptions().Validate());
  expect_error({.max_iterations = -1}, "max_iterations");
  expect_error({.threads = 0}, "threads");
  expect_error({.max_seconds = 0.0}, "max_seconds");
  for (const double bad : {-1e-9, nan}) {
    expect_error({.function_tolerance = bad}, "function_tolerance");
    expect_error({.gradient_tolerance = bad}, "gradient_tolerance");
    expect_error({.parameter_tolerance = bad}, "parameter_tolerance");
  }
  for (const double bad : {0.0, -1.0, nan, infinity}) {
    expect_error({.initial_trust_region_radius = bad}, "initial_trust_region_radius");
  }
}

TEST(FactorGraph, StaleHandlesAreRefusedEvenWhenTheirSlotIsUsedAgain) {
  FactorGraph graph;
  const auto old = graph.AddVariable(1.0);
  const FactorId old_factor = graph.AddFactor(MakeScalarPrior(0.0), old);
  graph.Remove(old);
  EXPECT_EQ(graph.NumFactors(), 0u);
  const auto fresh = graph.AddVariable(2.0);
  const FactorId fresh_factor = graph.AddFactor(MakeScalarPrior(0.0), fresh);
  EXPECT_EQ(fresh.index, old.index);
  EXPECT_FALSE(graph.Contains(old));
  EXPECT_FALSE(graph.Contains(old_factor));
  EXPECT_TRUE(graph.Contains(fresh));
  EXPECT_TRUE(graph.Contains(fresh_factor));
  EXPECT_THROW(graph.Value(old), InvalidArgument);
  EXPECT_THROW(graph.Remove(old), InvalidArgument);
  EXPECT_THROW(graph.RemoveFactor(old_factor), InvalidArgument);
  EXPECT_THROW(graph.AddFactor(MakeScalarPrior(0.0), old), InvalidArgument);
  EXPECT_FALSE(graph.Contains(Variable<double>()));
}

TEST(FactorGraph, RemovingAVariableTakesItsFactorsAndLeavesTheOthers) {
  FactorGraph graph;
  const auto a = graph.AddVariable(Pose()), b = graph.AddVariable(Pose()),
             c = graph.AddVariable(Pose());
  const auto make = [] { return std::make_unique<RelativePose>(Pose(), Matrix6::Identity()); };
  const FactorId ab = graph.AddFactor(make(), a, b);
  const FactorId bc = graph.AddFactor(make(), b, c);
  const FactorId ca = graph.AddFactor(make(), c, a);
  EXPECT_EQ(graph.FactorsOf(a), (std::vector<FactorId>{ab, ca}));
  EXPECT_EQ(graph.VariablesOf(bc), (std::vector<VariableId>{b, c}));
  graph.Remove(b);
  EXPECT_FALSE(graph.Contains(ab));
  EXPECT_FALSE(graph.Contains(bc));
  EXPECT_EQ(graph.FactorsOf(a), (std::vector<FactorId>{ca}));
  EXPECT_EQ(graph.NumFactors(), 1u);
  EXPECT_EQ(graph.problem().NumResidualBlocks(), 1);
  EXPECT_EQ(graph.problem().NumParameterBlocks(), 2);
}

// The handle passed is an element of the list from which it is removed.
TEST(FactorGraph, RemovesAFactorByAHandleFromTheListOfItsVariable) {
  FactorGraph graph;
  const auto a = graph.AddVariable(Pose()), b = graph.AddVariable(Pose());
  const auto make = [] { return std::make_unique<RelativePose>(Pose(), Matrix6::Identity()); };
  const FactorId first = graph.AddFactor(make(), a, b);
  const FactorId second = graph.AddFactor(make(), b, a);
  graph.RemoveFactor(graph.FactorsOf(a).front());
  EXPECT_FALSE(graph.Contains(first));
  EXPECT_EQ(graph.FactorsOf(a), (std::vector<FactorId>{second}));
  EXPECT_EQ(graph.FactorsOf(b), (std::vector<FactorId>{second}));
  EXPECT_EQ(graph.problem().NumResidualBlocks(), 1);
}

TEST(FactorGraph, KeepsASharedFactorAndLossAsLongAsTheyAreInUse) {
  std::shared_ptr<VectorPrior<1>> factor = MakeScalarPrior(1.0);
  auto loss = std::make_shared<ceres::HuberLoss>(1.0);
  {
    FactorGraph graph;
    const auto x = graph.AddVariable(5.0), y = graph.AddVariable(5.0);
    graph.AddFactor(factor, loss, x);
    const FactorId second = graph.AddFactor(factor, loss, y);
    EXPECT_EQ(factor.use_count(), 3);
    graph.RemoveFactor(second);
    EXPECT_EQ(factor.use_count(), 2);
    EXPECT_EQ(loss.use_count(), 2);
  }
  EXPECT_EQ(factor.use_count(), 1);
  EXPECT_EQ(loss.use_count(), 1);
}

TEST(FactorGraph, CostAppliesTheLossAndSquaredErrorDoesNot) {
  FactorGraph graph;
  const auto x = graph.AddVariable(5.0);
  const FactorId id =
      graph.AddFactor(MakeScalarPrior(1.0), std::make_shared<ceres::HuberLoss>(1.0), x);
  EXPECT_DOUBLE_EQ(graph.SquaredError(id), 16.0);
  EXPECT_DOUBLE_EQ(graph.Cost(), 3.5);  // Huber: (2 |r| - 1) / 2
  EXPECT_EQ(graph.Factor(id).num_residuals(), 1);
}

TEST(FactorGraph, FixedVariablesStayAndUnfixedOnesMove) {
  FactorGraph graph;
  const auto x = graph.AddVariable(5.0);
  graph.AddFactor(MakeScalarPrior(1.0), x);
  graph.Fix(x);
  EXPECT_TRUE(graph.Solve().IsUsable());
  EXPECT_EQ(graph.Value(x), 5.0);
  graph.Unfix(x);
  EXPECT_FALSE(graph.IsFixed(x));
  EXPECT_TRUE(graph.Solve().IsUsable());
  EXPECT_NEAR(graph.Value(x), 1.0, 1e-6);  // limited by the Levenberg-Marquardt damping of 1e-4
}

TEST(FactorGraph, AnEmptyGraphSolves) {
  FactorGraph graph;
  EXPECT_TRUE(graph.Solve().IsUsable());
  graph.AddVariable(1.0);
  EXPECT_TRUE(graph.Solve().IsUsable());
}

TEST(FactorGraph, ReportsTheIterationLimitAndAStop) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose::FromTangent({1, 2, 3}, {1, 1, 1}));
  graph.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), pose);
  EXPECT_EQ(graph.Solve({.max_iterations = 1, .function_tolerance = 0.0}).status,
            SolveStatus::kLimit);
  graph.SetValue(pose, Pose::FromTangent({1, 2, 3}, {1, 1, 1}));
  const std::atomic<bool> stop = true;
  const SolveSummary summary = graph.Solve({.stop = &stop});
  EXPECT_EQ(summary.status, SolveStatus::kStopped);
  EXPECT_STREQ(ToString(summary.status), "stopped");
}

// Has the residual x, but the residual or the Jacobian may be NaN.
class HalfNaN final : public ceres::SizedCostFunction<1, 1> {
 public:
  HalfNaN(bool residual, bool jacobian) : residual_(residual), jacobian_(jacobian) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    residuals[0] = residual_ ? nan : x[0][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = jacobian_ ? nan : 1.0;
    return true;
  }

 private:
  bool residual_, jacobian_;
};

// Returns the text that the calls print on standard error.
template <class Calls>
std::string PrintedBy(Calls calls) {
  ::testing::internal::CaptureStderr();
  calls();
  return ::testing::internal::GetCapturedStderr();
}

void ExpectNamed(const std::string& message) {
  EXPECT_NE(message.find("HalfNaN on variable 1 (double)"), std::string::npos) << message;
  EXPECT_NE(message.find("not finite"), std::string::npos) << message;
}
template <class Call>
void ExpectThrowsNamed(Call call) {
  try {
    call();
    ADD_FAILURE() << "no exception";
  } catch (const InvalidArgument& error) {
    ExpectNamed(error.what());
  }
}

TEST(FactorGraph, NamesAFactorThatCannotBeEvaluatedAndPrintsNothing) {
  for (const bool residual : {true, false}) {
    for (const bool fixed : {true, false}) {
      if (fixed && !residual) continue;  // the Jacobian of a fixed variable is not requested
      FactorGraph graph;
      const auto pose = graph.AddVariable(Pose());
      const auto x = graph.AddVariable(1.0);
      if (fixed) graph.Fix(x);
      graph.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), pose);
      const FactorId bad = graph.AddFactor(std::make_unique<HalfNaN>(residual, !residual), x);
      SolveSummary summary;
      int iterations = 0;
      EXPECT_EQ(PrintedBy([&] {
                  summary = graph.Solve({.on_iteration = [&](int, double) { ++iterations; }});
                }),
                "");
      EXPECT_EQ(summary.status, SolveStatus::kFailed);
      EXPECT_EQ(iterations, 0);
      ExpectNamed(summary.message);
      ExpectNamed(graph.FaultOf(bad));
      EXPECT_EQ(graph.Value(x), 1.0);
      EXPECT_EQ(PrintedBy([&] {
                  if (residual) ExpectThrowsNamed([&] { graph.Cost(); });
                  if (residual) ExpectThrowsNamed([&] { graph.SquaredError(bad); });
                  if (fixed) return;
                  EXPECT_FALSE(graph.Covariance(x));
                  ExpectNamed(graph.Undetermined());
                }),
                "");
      EXPECT_EQ(graph.FaultOf(graph.FactorsOf(pose).front()), "");
    }
  }
}

// sqrt(x) + 1: defined only for x > 0, with the minimum at the border of the domain.
class OnlyForPositive final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit OnlyForPositive(bool throws) : throws_(throws) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    if (throws_ && x[0][0] < 0.0) throw std::runtime_error("negative");
    residuals[0] = std::sqrt(x[0][0]) + 1.0;
    if (jacobians && jacobians[0]) jacobians[0][0] = 0.5 / std::sqrt(x[0][0]);
    return true;
  }

 private:
  bool throws_;
};

TEST(FactorGraph, AStepBeyondWhatAFactorAllowsPrintsNothingAndThrowsNothing) {
  for (const bool throws : {false, true}) {
    FactorGraph graph;
    const auto x = graph.AddVariable(4.0);
    graph.AddFactor(std::make_unique<OnlyForPositive>(throws), x);
    SolveSummary summary;
    // Undamped steps from 4 lead to -8 repeatedly.
    EXPECT_EQ(PrintedBy([&] {
                summary = graph.Solve({.threads = 2, .initial_trust_region_radius = 1e16});
              }),
              "");
    EXPECT_GT(graph.Value(x), 0.0);
    EXPECT_TRUE(summary.IsUsable() ||
                summary.message.find("OnlyForPositive on variable 0") != std::string::npos)
        << summary.message;
  }
}

TEST(FactorGraph, ASystemThatIsSingularPrintsNothing) {
  for (const LinearSolver solver :
       {LinearSolver::kDenseCholesky, LinearSolver::kSparseCholesky, LinearSolver::kDenseSchur,
        LinearSolver::kSparseSchur, LinearSolver::kCompactSchur,
        LinearSolver::kVariableProjection}) {
    FactorGraph graph;
    const auto a = graph.AddVariable(Pose()), b = graph.AddVariable(Pose());
    const auto point = graph.AddLandmark(Point(0, 0, 0));
    const Pose apart = Pose::FromTangent({1, 0, 0}, {0, 0, 1});
    graph.AddFactor(std::make_unique<RelativePose>(apart, Matrix6::Identity()), a, b);
    graph.AddFactor(MakeObservation(Point(0, 0, 1)), a, point);
    EXPECT_EQ(PrintedBy([&] { graph.Solve({.linear_solver = solver}); }), "");
  }
}

// Two coordinates of which only the sum is observed.
class SumOfTwo final : public ceres::SizedCostFunction<1, 2> {
 public:
  explicit SumOfTwo(double scale) : scale_(scale) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = scale_ * (x[0][0] + x[0][1] - 1.0);
    if (jacobians && jacobians[0]) jacobians[0][0] = jacobians[0][1] = scale_;
    return true;
  }

 private:
  double scale_;
};

TEST(FactorGraph, NamesTheVariableThatMakesASystemSingularAndPrintsNothing) {
  for (const LinearSolver solver : {LinearSolver::kDenseCholesky, LinearSolver::kSparseCholesky}) {
    FactorGraph graph;
    graph.Fix(graph.AddVariable(1.0));
    const auto x = graph.AddVariable(Eigen::Vector2d(3.0, 0.0));
    graph.AddFactor(std::make_unique<SumOfTwo>(1.0), x);
    SolveSummary summary;
    // With a damping of 1e-30 the system is singular, and it stays so while five steps shrink the
    // trust region.
    EXPECT_EQ(PrintedBy([&] {
                summary =
                    graph.Solve({.initial_trust_region_radius = 1e30, .linear_solver = solver});
              }),
              "");
    EXPECT_EQ(summary.status, SolveStatus::kFailed);
    EXPECT_EQ(graph.Value(x), Eigen::Vector2d(3.0, 0.0));
    for (const char* text :
         {"variable 1 (vector of 2) is not determined", "SumOfTwo on variable 1"}) {
      EXPECT_NE(summary.message.find(text), std::string::npos) << summary.message;
      EXPECT_NE(graph.Undetermined().find(text), std::string::npos) << graph.Undetermined();
    }
  }
  FactorGraph graph;
  const auto alone = graph.AddVariable(1.0);
  EXPECT_FALSE(graph.Covariance(alone));
  EXPECT_EQ(graph.Undetermined(), "variable 0 (double) is in no factor: fix it, or add a prior");
}

TEST(FactorGraph, CovarianceOfAVariableThatWasRemovedIsAnError) {
  FactorGraph graph, other;
  const auto x = graph.AddVariable(1.0);
  graph.Remove(x);
  EXPECT_THROW(graph.Covariance(x), InvalidArgument);
  EXPECT_THROW(graph.Covariance(other.AddVariable(1.0)), InvalidArgument);
}

TEST(FactorGraph, NamesAFactorWhoseSquareIsNoNumberAndPrintsNothing) {
  FactorGraph graph;
  const auto x = graph.AddVariable(Eigen::Vector2d(3.0, 0.0));
  graph.AddFactor(std::make_unique<SumOfTwo>(1e160), x);
  SolveSummary summary;
  EXPECT_EQ(PrintedBy([&] { summary = graph.Solve(); }), "");
  EXPECT_EQ(summary.status, SolveStatus::kFailed);
  for (const char* text : {"SumOfTwo on variable 0", "has a residual that is too large"}) {
    EXPECT_NE(summary.message.find(text), std::string::npos) << summary.message;
  }
}

TEST(FactorGraph, RefusesHandlesOfAnotherGraph) {
  FactorGraph graph, other;
  const auto x = graph.AddVariable(1.0), y = other.AddVariable(2.0);
  const FactorId f = graph.AddFactor(MakeScalarPrior(0.0), x);
  const FactorId g = other.AddFactor(MakeScalarPrior(0.0), y);
  EXPECT_FALSE(graph.Contains(y));
  EXPECT_FALSE(graph.Contains(g));
  EXPECT_THROW(graph.Value(y), InvalidArgument);
  EXPECT_THROW(graph.Fix(y), InvalidArgument);
  EXPECT_THROW(graph.AddFactor(MakeScalarPrior(0.0), y), InvalidArgument);
  EXPECT_THROW(graph.RemoveFactor(g), InvalidArgument);
  EXPECT_THROW(graph.SquaredError(g), InvalidArgument);
  // A handle becomes invalid when its graph is destroyed.
  const FactorGraph moved = std::move(graph);
  EXPECT_EQ(moved.Value(x), 1.0);
  EXPECT_EQ(moved.SquaredError(f), 1.0);
}

// Two scalars, x = 0 +- 2 and y - x = 0 +- 1 (a linear factor): var x = 4, var y = 5, cov = 4.
struct Difference {
  template <class S>
  bool operator()(const S* x, const S* y, S* r) const {
    r[0] = y[0] - x[0];
    return true;
  }
};

TEST(FactorGraph, CovarianceOfAHandComputedChain) {
  FactorGraph graph;
  const auto x = graph.AddVariable(0.0), y = graph.AddVariable(0.0);
  graph.AddFactor(MakeScalarPrior(0.0, 0.5), x);
  graph.AddFactor(
      std::make_unique<ceres::AutoDiffCostFunction<Difference, 1, 1, 1>>(new Difference), x, y);
  const std::vector<VariableId> both = {y, x};
  Eigen::Matrix2d expected;
  expected << 5.0, 4.0, 4.0, 4.0;
  EXPECT_TRUE(graph.Covariance(both)->isApprox(expected, 1e-12));
  EXPECT_NEAR((*graph.Covariance(y))(0, 0), 5.0, 1e-12);
  graph.Fix(x);
  EXPECT_NEAR((*graph.Covariance(y))(0, 0), 1.0, 1e-12);
  EXPECT_EQ((*graph.Covariance(x))(0, 0), 0.0);
}

TEST(FactorGraph, CovarianceOfAPoseIsInItsTangentSpace) {
  RandomStates random(5);
  const Matrix6 W = Matrix6::Identity() * 3.0 + random.Matrix<6>();
  FactorGraph graph;
  const Pose T = random.RandomPose();
  const auto pose = graph.AddVariable(T);
  graph.AddFactor(std::make_unique<PosePrior>(T, W), pose);
  EXPECT_TRUE(graph.Covariance(pose)->isApprox((W.transpose() * W).inverse(), 1e-10));
}

TEST(FactorGraph, OfAFreeGaugeThereIsNoCovarianceAndOtherUnknownsDoNotMatter) {
  RandomStates random(6);
  FactorGraph graph;
  const Pose A = random.RandomPose(), B = random.RandomPose();
  const auto a = graph.AddVariable(A), b = graph.AddVariable(B);
  graph.AddFactor(std::make_unique<RelativePose>(A.Inverse() * B, Matrix6::Identity()), a, b);
  EXPECT_FALSE(graph.Covariance(a));
  EXPECT_NE(graph.Undetermined(), "");
  graph.Fix(a);
  const Eigen::MatrixXd of_b = *graph.Covariance(b);
  EXPECT_EQ(of_b.rows(), 6);
  EXPECT_EQ(graph.Undetermined(), "");
  const auto loose = graph.AddVariable(1.0);  // a variable without factors
  EXPECT_TRUE(graph.Covariance(b)->isApprox(of_b, 1e-12));
  EXPECT_FALSE(graph.Covariance(loose));
  const std::vector<VariableId> twice = {b, a, b};
  EXPECT_TRUE(graph.Covariance(twice)->bottomRightCorner(6, 6).isApprox(of_b, 1e-12));
}

}  // namespace
}  // namespace highwall::factor_graph_test
