#include "robust_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace highwall::internal {
namespace {

constexpr int kUnlimited = std::numeric_limits<int>::max();

std::vector<std::size_t> LoopsOf(const PoseGraph& graph) {
  std::vector<std::size_t> loops;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].IsLoop()) loops.push_back(e);
  }
  return loops;
}

void AddOdometry(const PoseGraph& graph, PoseGraphProblem* problem) {
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].IsLoop()) problem->AddEdge(e);
  }
}

// A weight that changes between solves.
class WeightLoss final : public ceres::LossFunction {
 public:
  // Never zero, which could leave a node without any factor.
  void set_weight(double weight) { weight_ = std::max(weight, 1e-8); }
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = weight_ * s;
    rho[1] = weight_;
    rho[2] = 0.0;
  }

 private:
  double weight_ = 1.0;
};

// docs/pose_graph.md, Eq. 7 (Yang et al. 2020, Eq. 14).
double TruncatedWeight(double chi2, double mu, double max_chi2) {
  if (chi2 <= mu / (mu + 1.0) * max_chi2) return 1.0;
  if (chi2 >= (mu + 1.0) / mu * max_chi2) return 0.0;
  return std::clamp(std::sqrt(max_chi2 * mu * (mu + 1.0) / chi2) - mu, 0.0, 1.0);
}

// Graduated non-convexity over truncated least squares.
class GraduatedNonConvexity {
 public:
  GraduatedNonConvexity(double max_chi2, const StageSolver& solve, PoseGraph* graph)
      : max_chi2_(max_chi2),
        solve_(solve),
        graph_(*graph),
        topology_(*graph),
        problem_(*graph, topology_),
        loops_(LoopsOf(*graph)) {
    AddOdometry(graph_, &problem_);
    for (const std::size_t loop : loops_) {
      losses_.push_back(std::make_shared<WeightLoss>());
      problem_.AddEdge(loop, losses_.back());
    }
  }

  std::vector<double> Run() {
    constexpr double kGrowth = 1.4;
    constexpr int kMaxStages = 200;
    constexpr int kIterations = 2;  // between two values of mu
    std::vector<double> weights(graph_.edges.size(), 1.0);
    const double ratio = 2.0 * LargestChi2() / max_chi2_ - 1.0;
    // Eq. 8. If it is negative, no loop is truncated.
    double mu = 1.0 / ratio;
    for (int stage = 0; ratio > 0.0 && stage < kMaxStages; ++stage, mu *= kGrowth) {
      if (Reweigh(mu, &weights)) break;
      const SolveSummary solved = solve_(problem_, kIterations);
      if (!solved.IsUsable() || solved.status == SolveStatus::kStopped) break;
    }
    problem_.CopyPosesTo(&graph_);
    return weights;
  }

 private:
  double LargestChi2() const {
    double largest = 0.0;
    for (const std::size_t loop : loops_) largest = std::max(largest, problem_.EdgeChi2(loop));
    return largest;
  }

  // Returns true once every loop is either accepted or rejected.
  bool Reweigh(double mu, std::vector<double>* weights) {
    bool decided = true;
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      const double weight = TruncatedWeight(problem_.EdgeChi2(loops_[k]), mu, max_chi2_);
      losses_[k]->set_weight(weight);
      (*weights)[loops_[k]] = weight;
      decided &= weight < 1e-3 || weight > 0.999;
    }
    return decided;
  }

  const double max_chi2_;
  const StageSolver& solve_;
  PoseGraph& graph_;
  const PoseGraphTopology topology_;
  PoseGraphProblem problem_;
  const std::vector<std::size_t> loops_;
  std::vector<std::shared_ptr<WeightLoss>> losses_;
};

// Eq. 9: the cost whose weight is the square of the scale s = min(1, 2 Phi / (Phi + chi2))
// (Agarwal et al. 2013, Eq. 15).
class ScalingLoss final : public ceres::LossFunction {
 public:
  explicit ScalingLoss(double phi) : phi_(phi) {}
  void Evaluate(double chi2, double rho[3]) const override {
    if (chi2 <= phi_) {
      rho[0] = chi2;
      rho[1] = 1.0;
      rho[2] = 0.0;
      return;
    }
    const double s = 2.0 * phi_ / (phi_ + chi2);
    rho[0] = phi_ * (3.0 * chi2 - phi_) / (chi2 + phi_);
    rho[1] = s * s;
    rho[2] = -2.0 * s * s / (phi_ + chi2);
  }

 private:
  const double phi_;
};

std::vector<double> ScaleDynamically(double phi, const StageSolver& solve, PoseGraph* graph) {
  const PoseGraphTopology topology(*graph);
  PoseGraphProblem problem(*graph, topology);
  AddOdometry(*graph, &problem);
  const auto loss = std::make_shared<ScalingLoss>(phi);
  const std::vector<std::size_t> loops = LoopsOf(*graph);
  for (const std::size_t loop : loops) problem.AddEdge(loop, loss);
  solve(problem, kUnlimited);
  std::vector<double> weights(graph->edges.size(), 1.0);
  for (const std::size_t loop : loops) {
    weights[loop] = std::min(1.0, 2.0 * phi / (phi + problem.EdgeChi2(loop)));
  }
  problem.CopyPosesTo(graph);
  return weights;
}

// Eq. 10: [s r | sqrt(Xi) (1 - s)], with the switch s as one more block.
class SwitchedFactor final : public ceres::CostFunction {
 public:
  SwitchedFactor(std::shared_ptr<ceres::CostFunction> factor, double xi)
      : factor_(std::move(factor)), sqrt_xi_(std::sqrt(xi)) {
    *mutable_parameter_block_sizes() = factor_->parameter_block_sizes();
    mutable_parameter_block_sizes()->push_back(1);
    set_num_residuals(factor_->num_residuals() + 1);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    if (!factor_->Evaluate(parameters, residuals, jacobians)) return false;
    const int rows = factor_->num_residuals();
    const std::size_t last = parameter_block_sizes().size() - 1;
    const double s = *parameters[last];
    if (jacobians != nullptr && jacobians[last] != nullptr) {
      std::copy_n(residuals, rows, jacobians[last]);
      jacobians[last][rows] = -sqrt_xi_;
    }
    for (std::size_t block = 0; jacobians != nullptr && block < last; ++block) {
      if (jacobians[block] == nullptr) continue;
      const int size = rows * parameter_block_sizes()[block];
      std::for_each_n(jacobians[block], size, [s](double& entry) { entry *= s; });
      std::fill_n(jacobians[block] + size, parameter_block_sizes()[block], 0.0);
    }
    std::for_each_n(residuals, rows, [s](double& r) { r *= s; });
    residuals[rows] = sqrt_xi_ * (1.0 - s);
    return std::isfinite(s);
  }

 private:
  const std::shared_ptr<ceres::CostFunction> factor_;
  const double sqrt_xi_;
};

std::vector<double> Switch(double xi, const StageSolver& solve, PoseGraph* graph) {
  const PoseGraphTopology topology(*graph);
  PoseGraphProblem problem(*graph, topology);
  AddOdometry(*graph, &problem);
  const std::vector<std::size_t> loops = LoopsOf(*graph);
  std::vector<Variable<double>> switches;
  for (const std::size_t loop : loops) {
    switches.push_back(problem.graph().AddVariable(1.0));
    problem.AddSwitchedEdge(loop, std::make_shared<SwitchedFactor>(problem.factor(loop), xi),
                            switches.back());
  }
  solve(problem, kUnlimited);
  std::vector<double> weights(graph->edges.size(), 1.0);
  for (std::size_t k = 0; k < loops.size(); ++k) {
    weights[loops[k]] = std::clamp(problem.graph().Value(switches[k]), 0.0, 1.0);
  }
  problem.CopyPosesTo(graph);
  return weights;
}

}  // namespace

std::vector<double> WeighLoops(RobustLoops method, double max_loop_chi2, const StageSolver& solve,
                               PoseGraph* graph) {
  switch (method) {
    case RobustLoops::kNone:
      break;
    case RobustLoops::kGnc:
      return GraduatedNonConvexity(max_loop_chi2, solve, graph).Run();
    case RobustLoops::kDcs:
      return ScaleDynamically(max_loop_chi2, solve, graph);
    case RobustLoops::kSwitchable:
      // A chi2 of Xi already halves s; the other methods keep full weight there: Xi must be larger.
      return Switch(4.0 * max_loop_chi2, solve, graph);
  }
  return std::vector<double>(graph->edges.size(), 1.0);
}

}  // namespace highwall::internal
