#pragma once

#include <memory>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/pose_graph.h>
#include "pose_graph_topology.h"

namespace highwall::internal {

// The whitened residual of an edge: docs/pose_graph.md, Eq. 1 and 2.
std::shared_ptr<ceres::CostFunction> MakeEdgeFactor(PoseGraphSpace space,
                                                    const PoseGraphEdge& edge);

// highwall::EdgeChi2() of a valid graph.
std::vector<double> EdgeChi2(const PoseGraph& graph, const PoseGraphTopology& topology);

// A pose graph as variables and factors: user factors are included, those of edges are added one by
// one.
class PoseGraphProblem {
 public:
  // graph: valid; both must outlive the problem.
  PoseGraphProblem(const PoseGraph& graph, const PoseGraphTopology& topology);

  FactorId AddEdge(std::size_t edge, std::shared_ptr<ceres::LossFunction> loss = nullptr);
  // Adds `factor` on the blocks of the edge and one more variable.
  void AddSwitchedEdge(std::size_t edge, std::shared_ptr<ceres::CostFunction> factor,
                       const VariableId& with);

  const std::shared_ptr<ceres::CostFunction>& factor(std::size_t edge) const {
    return factors_[edge];
  }
  const VariableId& variable(std::size_t node) const { return variables_[node]; }
  // At the current values; infinite if the factor cannot be evaluated.
  double EdgeChi2(std::size_t edge) const;
  void CopyPosesTo(PoseGraph* graph) const;

  FactorGraph& graph() { return graph_; }

 private:
  const PoseGraphSpace space_;
  const PoseGraphTopology& topology_;
  std::vector<std::shared_ptr<ceres::CostFunction>> factors_;  // by edge
  std::vector<VariableId> variables_;                          // by node
  FactorGraph graph_;
};

}  // namespace highwall::internal
