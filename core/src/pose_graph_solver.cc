#include <algorithm>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/pose_graph.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>
#include <highwall/internal/stopwatch.h>
#include "loop_consistency.h"
#include "pose_graph_problem.h"
#include "pose_graph_topology.h"
#include "robust_loops.h"

namespace highwall {
namespace {

using internal::PoseGraphProblem;
using internal::PoseGraphTopology;

// 99.9 % quantiles of the chi-squared distribution with 3 and 6 degrees of freedom.
constexpr double kMaxChi2Se2 = 16.266;
constexpr double kMaxChi2Se3 = 22.458;
constexpr double kMinWeight = 0.5;  // of a loop that is kept

// Returns the graph with the selected edges only.
PoseGraph Select(const PoseGraph& graph, const std::vector<bool>& used) {
  PoseGraph selected = graph;
  selected.edges.clear();
  for (std::size_t e = 0; e < used.size(); ++e) {
    if (used[e]) selected.edges.push_back(graph.edges[e]);
  }
  return selected;
}

class PoseGraphSolver {
 public:
  PoseGraphSolver(const PoseGraphOptions& options, PoseGraph* graph)
      : options_(options),
        max_chi2_(options.max_loop_chi2 > 0.0            ? options.max_loop_chi2
                  : graph->space == PoseGraphSpace::kSe2 ? kMaxChi2Se2
                                                         : kMaxChi2Se3),
        graph_(*graph),
        topology_(*graph),
        weights_(graph->edges.size(), 1.0) {}

  PoseGraphSummary Run() {
    const Stopwatch stopwatch;
    const std::vector<PoseGraphNode> before = graph_.nodes;
    for (const double chi2 : internal::EdgeChi2(graph_, topology_)) summary_.initial_chi2 += chi2;
    Describe();
    if (options_.robust != RobustLoops::kNone) FindFalseLoops();
    if (options_.robust == RobustLoops::kNone || SolvedOn()) SolveKept();
    while (SolvedOn() && TakeBackLoops()) SolveKept();
    if (summary_.status == SolveStatus::kFailed) graph_.nodes = before;
    Conclude();
    summary_.seconds = stopwatch.Seconds();
    return std::move(summary_);
  }

 private:
  void Describe() {
    summary_.components = static_cast<int>(topology_.components);
    if (topology_.components < 2) return;
    summary_.warnings.push_back("the graph is in " + std::to_string(topology_.components) +
                                " pieces that no edge joins; each is solved by itself");
  }

  SolveSummary SolveStage(PoseGraphProblem& problem, int max_iterations) {
    SolveOptions options = options_.solver;
    options.max_iterations = std::min(options.max_iterations, max_iterations);
    if (options_.on_progress) {
      options.on_iteration = [this](int iteration, double cost) {
        options_.on_progress({summary_.iterations + iteration, 2.0 * cost});
      };
    }
    const SolveSummary solved = problem.graph().Solve(options);
    summary_.iterations += solved.iterations;
    summary_.status = solved.status;
    summary_.message = solved.message;
    return solved;
  }

  // Sets weights_. Loops are used only once other information supports them, so that many outliers
  // neither pull the poses into a wrong minimum nor fill the normal equations.
  void FindFalseLoops() {
    const auto solve = [this](PoseGraphProblem& problem, int max_iterations) {
      return SolveStage(problem, max_iterations);
    };
    std::vector<bool> used =
        internal::ConfirmedLoops(graph_, max_chi2_, options_.estimate_variance_factor);
    std::vector<int> refusals(used.size(), 0);
    ImproveStart(used);
    for (bool more = true; more;) {
      PoseGraph selected = Select(graph_, used);
      SolvePlainly(PoseGraphTopology(selected), &selected);
      if (!SolvedOn()) return;
      const std::vector<double> weights =
          internal::WeighLoops(options_.robust, max_chi2_, solve, &selected);
      if (!SolvedOn()) return;
      graph_.nodes = selected.nodes;
      for (std::size_t e = 0, k = 0; e < used.size(); ++e) {
        weights_[e] = used[e] ? weights[k++] : 0.0;
        const bool trusted = weights_[e] >= kMinWeight;
        if (used[e] && !trusted) ++refusals[e];
        used[e] = trusted;
      }
      more = AddPlausible(refusals, &used);
    }
  }

  // used: the trusted edges. Returns true if any edge was added.
  bool AddPlausible(const std::vector<int>& refusals, std::vector<bool>* used) const {
    constexpr int kMaxRefusals = 2;  // the first may have been caused by other loops of its round
    std::vector<bool> candidates;
    for (std::size_t e = 0; e < used->size(); ++e) {
      candidates.push_back(!(*used)[e] && refusals[e] < kMaxRefusals);
    }
    const double factor =
        options_.estimate_variance_factor ? VarianceFactor(Select(graph_, *used)) : 1.0;
    const auto surest =
        internal::SurestPlausibleLoops(graph_, factor * max_chi2_, *used, candidates);
    for (const std::size_t edge : surest) (*used)[edge] = true;
    return !surest.empty();
  }

  // Returns chi-squared per degree of freedom, with a margin, at most 1: if the information is too
  // small, the covariance of a path would accept any loop. Shrunk towards 1 if there are few loops.
  static double VarianceFactor(const PoseGraph& solved) {
    constexpr double kPrior = 30.0;  // degrees of freedom of the prior value 1
    constexpr double kMargin = 2.0;
    const double dimension = solved.space == PoseGraphSpace::kSe2 ? 3.0 : 6.0;
    const double freedom = dimension * (static_cast<double>(solved.edges.size()) -
                                        static_cast<double>(solved.nodes.size()));
    const double factor = (Chi2(solved) + kPrior) / (std::max(0.0, freedom) + kPrior);
    return std::min(1.0, kMargin * factor);
  }

  bool SolvedOn() const {
    return summary_.status != SolveStatus::kFailed && summary_.status != SolveStatus::kStopped;
  }

  // False loops may have distorted the given poses: they are replaced by the chordal relaxation of
  // the remaining edges if that fits these edges better.
  void ImproveStart(const std::vector<bool>& used) {
    if (!graph_.factors.empty()) return;  // not supported by the chordal relaxation
    PoseGraph given = Select(graph_, used);
    PoseGraph relaxed = given;
    InitializePoseGraph(&relaxed, PoseGraphInitialization::kChordal);
    if (Chi2(relaxed) < Chi2(given)) graph_.nodes = std::move(relaxed.nodes);
  }

  bool IsKept(std::size_t edge) const { return weights_[edge] >= kMinWeight; }

  void SolveKept() {
    std::vector<bool> kept;
    for (std::size_t e = 0; e < weights_.size(); ++e) kept.push_back(IsKept(e));
    if (std::find(kept.begin(), kept.end(), false) == kept.end()) {
      SolvePlainly(topology_, &graph_);
      return;
    }
    PoseGraph selected = Select(graph_, kept);
    SolvePlainly(PoseGraphTopology(selected), &selected);
    graph_.nodes = std::move(selected.nodes);
  }

  // Readmits rejected loops that fit the solution. Returns true if there are any.
  bool TakeBackLoops() {
    if (options_.robust == RobustLoops::kNone) return false;
    const std::vector<double> chi2 = internal::EdgeChi2(graph_, topology_);
    bool more = false;
    for (std::size_t e = 0; e < chi2.size(); ++e) {
      if (IsKept(e) || chi2[e] >= max_chi2_) continue;
      weights_[e] = 1.0;
      more = true;
    }
    return more;
  }

  void SolvePlainly(const PoseGraphTopology& topology, PoseGraph* graph) {
    PoseGraphProblem problem(*graph, topology);
    for (std::size_t e = 0; e < graph->edges.size(); ++e) problem.AddEdge(e);
    SolveStage(problem, options_.solver.max_iterations);
    problem.CopyPosesTo(graph);
  }

  void Conclude() {
    const std::vector<double> chi2 = internal::EdgeChi2(graph_, topology_);
    for (std::size_t e = 0; e < chi2.size(); ++e) {
      if (IsKept(e)) {
        summary_.final_chi2 += chi2[e];
      } else {
        summary_.rejected.push_back({e, chi2[e], weights_[e], Reason(chi2[e])});
      }
    }
  }

  std::string Reason(double chi2) const {
    return "chi2 " + RoundedText(chi2, 4) + " against odometry and the other loops exceeds " +
           RoundedText(max_chi2_, 4);
  }

  const PoseGraphOptions& options_;
  const double max_chi2_;
  PoseGraph& graph_;
  const PoseGraphTopology topology_;
  std::vector<double> weights_;  // by edge
  PoseGraphSummary summary_;
};

}  // namespace

void PoseGraphOptions::Validate() const {
  RequireNotNegativeFinite(max_loop_chi2, "PoseGraphOptions::max_loop_chi2");
  solver.Validate();
}

PoseGraphSummary SolvePoseGraph(PoseGraph* graph, const PoseGraphOptions& options) {
  options.Validate();
  internal::RequireValues(*graph);
  HIGHWALL_REQUIRE(graph->has_poses,
                   "SolvePoseGraph: the graph has no poses to begin with: initialize it first");
  return PoseGraphSolver(options, graph).Run();
}

}  // namespace highwall
