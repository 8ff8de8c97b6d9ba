// When a solve by Ceres of all variables ends, and with how many threads of OpenMP.
#include <highwall/core/factor_graph.h>
#include <highwall/core/pose_graph.h>
#include <highwall/core/relative_pose.h>

#include <memory>
#include <string>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "support/pose_graph_scenes.h"

extern "C" {
[[gnu::weak]] int omp_get_max_active_levels();
}

namespace highwall::solve_convergence_test {
namespace {

bool EndedByPrediction(const std::string& message) {
  return message.find("predicted to gain less") != std::string::npos;
}

TEST(SolveConvergence, APoseGraphEndsWhereItsNextStepWouldGainLessThanTheTolerance) {
  for (const PoseGraph& scene : {MakeSphere(4), MakeField(4)}) {
    PoseGraph graph = scene;
    InitializePoseGraph(&graph, PoseGraphInitialization::kChordal);
    const PoseGraphSummary summary = SolvePoseGraph(&graph);
    EXPECT_EQ(summary.status, SolveStatus::kConverged);
    EXPECT_TRUE(EndedByPrediction(summary.message)) << summary.message;
    PoseGraph further = graph;
    PoseGraphOptions options;
    options.solver.function_tolerance = 0.0;
    options.solver.parameter_tolerance = 1e-14;
    const double left = summary.final_chi2 - SolvePoseGraph(&further, options).final_chi2;
    // The prediction is within a factor of ten, and the tolerance 1e-6 of the cost.
    EXPECT_LT(left, 1e-5 * summary.final_chi2);
  }
}

struct Difference {
  double measured, weight;
  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    r[0] = T(weight) * (b[0] - a[0] * a[0] - T(measured));
    return true;
  }
};

// Gauss-Newton converges linearly here: residuals at the minimum are large.
SolveSummary SolveScalars(FactorGraph* graph, VariableId a, VariableId b,
                          const SolveOptions& options) {
  for (const double measured : {-1.0, 0.0, 1.3}) {
    graph->AddFactorToBlocks(std::make_shared<ceres::AutoDiffCostFunction<Difference, 1, 1, 1>>(
                                 new Difference{measured, 1.0 + measured * measured}),
                             nullptr, std::vector{a, b});
  }
  return graph->Solve(options);
}

TEST(SolveConvergence, GradientsOfVariablesOfSeveralTypesPredictNothing) {
  FactorGraph alike, mixed;
  const auto a = alike.AddVariable(3.0), b = alike.AddVariable(-2.0);
  const SolveSummary of_alike = SolveScalars(&alike, a, b, {});
  EXPECT_TRUE(EndedByPrediction(of_alike.message)) << of_alike.message;
  // The same cost, and a pose on which nothing else depends.
  const auto c = mixed.AddVariable(3.0), d = mixed.AddVariable(-2.0);
  const auto pose = mixed.AddVariable(Pose());
  mixed.AddFactorToBlocks(
      std::make_shared<RelativePose>(Pose(), Eigen::Matrix<double, 6, 6>::Identity()), nullptr,
      std::vector<VariableId>{pose, mixed.AddVariable(Pose())});
  const SolveSummary of_mixed = SolveScalars(&mixed, c, d, {});
  EXPECT_EQ(of_mixed.status, SolveStatus::kConverged);
  EXPECT_FALSE(EndedByPrediction(of_mixed.message)) << of_mixed.message;
}

TEST(SolveConvergence, OneThreadMeansNoThreadOfOpenMp) {
  ASSERT_NE(omp_get_max_active_levels, nullptr) << "CHOLMOD without OpenMP: nothing to limit";
  const int before = omp_get_max_active_levels();
  ASSERT_GT(before, 0);
  for (const int threads : {1, 2}) {
    std::vector<int> levels;
    PoseGraph graph = MakeField(4);
    InitializePoseGraph(&graph, PoseGraphInitialization::kChordal);
    PoseGraphOptions options;
    options.solver.threads = threads;
    options.on_progress = [&](const PoseGraphProgress&) {
      levels.push_back(omp_get_max_active_levels());
    };
    SolvePoseGraph(&graph, options);
    ASSERT_GT(levels.size(), 1U);
    for (const int level : levels) EXPECT_EQ(level, threads == 1 ? 0 : before);
    EXPECT_EQ(omp_get_max_active_levels(), before);
  }
}

}  // namespace
}  // namespace highwall::solve_convergence_test
