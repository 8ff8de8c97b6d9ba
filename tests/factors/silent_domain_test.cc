#include <highwall/core/silent_domain.h>

#include <memory>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/factors/extrinsic_factor.h>
#include <highwall/factors/point_reprojection.h>

#include "reprojection_scene.h"

namespace highwall::silent_domain_test {
namespace {

// A point that is constrained to the ray x = 0.1, at 2 m according to its image and at 5 m
// initially: the next Gauss-Newton iterate is 2 * 5 - 25 / 2 = -2.5 m.
constexpr double kTrue = 2.0, kStart = 5.0;

template <class AddPoint>
Variable<Point> Hold(FactorGraph* graph, const AddPoint& add) {
  const Variable<Point> point = add(Point(0.1, 0.0, kStart));
  const Eigen::Vector3d weights(1e6, 1e6, 0.0);
  graph->AddFactor(std::make_unique<VectorPrior<3>>(Eigen::Vector3d(0.1, 0.0, 0.0),
                                                    Eigen::Matrix3d(weights.asDiagonal())),
                   point);
  return point;
}

Eigen::Vector2d Seen() {
  return {320.0 + 500.0 * 0.1 / kTrue, 240.0};
}

class SilentDomain : public ::testing::TestWithParam<LinearSolver> {};

TEST_P(SilentDomain, AStepThatLeadsBehindTheCameraIsNotTaken) {
  FactorGraph graph;
  // If the other unknowns are already at their optimum, variable projection ends before landmarks
  // move.
  const auto pose = graph.AddVariable(Pose::FromTangent({1e-5, 0, 0}, {0, 0, 0}));
  graph.AddFactor(
      std::make_unique<PosePrior>(Pose(), 1e4 * Eigen::Matrix<double, 6, 6>::Identity()), pose);
  const auto point = Hold(&graph, [&](const Point& p) { return graph.AddLandmark(p); });
  graph.AddFactor(
      std::make_unique<PointReprojection>(Seen(), Eigen::Matrix2d::Identity(), SimpleProjection()),
      pose, point);
  const SolveSummary summary = graph.Solve({.max_iterations = 100,
                                            .function_tolerance = 1e-12,
                                            .initial_trust_region_radius = 1e12,
                                            .linear_solver = GetParam()});
  ASSERT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_NEAR(graph.Value(point).z(), kTrue, 0.05);
  EXPECT_LT(summary.final_cost, 1e-3 * summary.initial_cost);
}

INSTANTIATE_TEST_SUITE_P(Solvers, SilentDomain,
                         ::testing::Values(LinearSolver::kAuto, LinearSolver::kDenseCholesky,
                                           LinearSolver::kSparseCholesky, LinearSolver::kDenseSchur,
                                           LinearSolver::kSparseSchur, LinearSolver::kCompactSchur,
                                           LinearSolver::kVariableProjection));

TEST(SilentDomain, AFactorThatWrapsOneIsHeldInItsDomain) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose()), T_BC = graph.AddVariable(Pose());
  graph.Fix(pose);
  graph.Fix(T_BC);
  const auto point = Hold(&graph, [&](const Point& p) { return graph.AddVariable(p); });
  graph.AddFactorToBlocks(std::make_shared<ExtrinsicFactor>(std::make_shared<PointReprojection>(
                              Seen(), Eigen::Matrix2d::Identity(), SimpleProjection())),
                          nullptr, std::vector<VariableId>{pose, point, T_BC});
  const SolveSummary summary =
      graph.Solve({.max_iterations = 100, .initial_trust_region_radius = 1e12});
  ASSERT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_GT(summary.rejected_steps, 0);
  EXPECT_NEAR(graph.Value(point).z(), kTrue, 0.01);
}

// Five iterations, as in a local bundle adjustment.
TEST(SilentDomain, APointThatMovesBehindTheCameraDoesNotStopTheOthers) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose());
  graph.Fix(pose);
  const auto bad = graph.AddVariable(Point(0.1, 0.0, 20.0));
  graph.AddFactor(
      std::make_unique<PointReprojection>(Seen(), Eigen::Matrix2d::Identity(), SimpleProjection()),
      pose, bad);
  const auto good = graph.AddVariable(Point(0.3, 0.0, 2.2));
  const RgbdProjection projection = SimpleProjection();
  for (const double x : {-0.5, 0.5}) {
    const auto from = graph.AddVariable(Pose::FromTangent({x, 0, 0}, {0, 0, 0}));
    graph.Fix(from);
    const Eigen::Vector3d p_C(0.3 - x, 0.0, 2.0);
    const Eigen::Vector2d uv(320.0 + 500.0 * p_C.x() / p_C.z(), 240.0);
    graph.AddFactor(
        std::make_unique<PointReprojection>(uv, Eigen::Matrix2d::Identity(), projection), from,
        good);
  }
  const SolveSummary summary =
      graph.Solve({.max_iterations = 5, .initial_trust_region_radius = 1e4});
  ASSERT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_LT((graph.Value(good) - Point(0.3, 0.0, 2.0)).norm(), 1e-3);
}

TEST(SilentDomain, APointOutsideFromTheBeginningDoesNotAffectTheOthers) {
  FactorGraph graph;
  const auto pose = graph.AddVariable(Pose());
  graph.Fix(pose);
  const auto behind = graph.AddVariable(Point(0.0, 0.0, -1.0));
  graph.AddFactor(std::make_unique<VectorPrior<3>>(Eigen::Vector3d(0.0, 0.0, -2.0),
                                                   Eigen::Matrix3d::Identity()),
                  behind);
  graph.AddFactor(
      std::make_unique<PointReprojection>(Seen(), Eigen::Matrix2d::Identity(), SimpleProjection()),
      pose, behind);
  ASSERT_TRUE(graph.Solve().IsUsable());
  EXPECT_NEAR(graph.Value(behind).z(), -2.0, 1e-3);
}

// A bound has a zero residual and Jacobian where it is satisfied, which is intended.
class AtLeastOne final : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const bool kept = x[0][0] >= 1.0;
    r[0] = kept ? 0.0 : 1.0 - x[0][0];
    if (J != nullptr && J[0] != nullptr) J[0][0] = kept ? 0.0 : -1.0;
    return true;
  }
};

TEST(SilentDomain, AFactorWhoseSilenceIsItsMeaningMayFallSilent) {
  FactorGraph graph;
  const auto x = graph.AddVariable(-3.0);
  graph.AddFactor(std::make_unique<AtLeastOne>(), x);
  const SolveSummary summary = graph.Solve({.initial_trust_region_radius = 1e12});
  ASSERT_TRUE(summary.IsUsable());
  EXPECT_NEAR(graph.Value(x), 1.0, 1e-6);
  EXPECT_EQ(summary.rejected_steps, 0);
}

}  // namespace
}  // namespace highwall::silent_domain_test
