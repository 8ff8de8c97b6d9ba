#include "pose_graph_problem.h"

#include <array>
#include <limits>

#include <highwall/core/relative_pose.h>
#include "planar_pose.h"
#include "planar_relative_pose.h"
#include "pose_information.h"

namespace highwall::internal {
namespace {

// Infinite if the factor cannot be evaluated.
double Chi2Of(const ceres::CostFunction& factor, const double* i, const double* j) {
  const double* const blocks[] = {i, j};
  Eigen::Matrix<double, 6, 1> r = Eigen::Matrix<double, 6, 1>::Zero();
  if (!factor.Evaluate(blocks, r.data(), nullptr)) return std::numeric_limits<double>::infinity();
  return r.squaredNorm();
}

}  // namespace

std::shared_ptr<ceres::CostFunction> MakeEdgeFactor(PoseGraphSpace space,
                                                    const PoseGraphEdge& edge) {
  if (space == PoseGraphSpace::kSe2) {
    return std::make_shared<PlanarRelativePose>(ToPlanar(edge.Z),
                                                SqrtOfInformation<3>(edge.information));
  }
  return std::make_shared<RelativePose>(edge.Z, SqrtOfInformation<6>(edge.information));
}

std::vector<double> EdgeChi2(const PoseGraph& graph, const PoseGraphTopology& topology) {
  const bool planar = graph.space == PoseGraphSpace::kSe2;
  std::vector<Eigen::Vector3d> planar_poses;
  if (planar) {
    for (const PoseGraphNode& node : graph.nodes) planar_poses.push_back(ToPlanar(node.pose));
  }
  const auto block = [&](std::size_t n) {
    return planar ? planar_poses[n].data() : graph.nodes[n].pose.data();
  };
  std::vector<double> chi2;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const auto& [i, j] = topology.ends[e];
    chi2.push_back(Chi2Of(*MakeEdgeFactor(graph.space, graph.edges[e]), block(i), block(j)));
  }
  return chi2;
}

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph, const PoseGraphTopology& topology)
    : space_(graph.space), topology_(topology) {
  factors_.reserve(graph.edges.size());
  for (const PoseGraphEdge& edge : graph.edges) {
    factors_.push_back(MakeEdgeFactor(graph.space, edge));
  }
  variables_.reserve(graph.nodes.size());
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Pose& pose = graph.nodes[n].pose;
    variables_.push_back(space_ == PoseGraphSpace::kSe2
                             ? static_cast<VariableId>(graph_.AddVariable(ToPlanar(pose)))
                             : static_cast<VariableId>(graph_.AddVariable(pose)));
    if (topology.held[n]) graph_.Fix(variables_.back());
  }
  for (const PoseGraphFactor& factor : graph.factors) {
    std::vector<VariableId> blocks;
    for (const std::int64_t id : factor.nodes) blocks.push_back(variables_[topology.IndexOf(id)]);
    graph_.AddFactorToBlocks(factor.cost, factor.loss, blocks);
  }
}

FactorId PoseGraphProblem::AddEdge(std::size_t edge, std::shared_ptr<ceres::LossFunction> loss) {
  const auto& [i, j] = topology_.ends[edge];
  return graph_.AddFactorToBlocks(factors_[edge], std::move(loss),
                                  std::array{variables_[i], variables_[j]});
}

void PoseGraphProblem::AddSwitchedEdge(std::size_t edge,
                                       std::shared_ptr<ceres::CostFunction> factor,
                                       const VariableId& with) {
  const auto& [i, j] = topology_.ends[edge];
  graph_.AddFactorToBlocks(std::move(factor), nullptr,
                           std::array{variables_[i], variables_[j], with});
}

double PoseGraphProblem::EdgeChi2(std::size_t edge) const {
  const auto& [i, j] = topology_.ends[edge];
  return Chi2Of(*factors_[edge], graph_.Block(variables_[i]), graph_.Block(variables_[j]));
}

void PoseGraphProblem::CopyPosesTo(PoseGraph* graph) const {
  for (std::size_t n = 0; n < graph->nodes.size(); ++n) {
    if (topology_.held[n]) continue;
    const double* const block = graph_.Block(variables_[n]);
    graph->nodes[n].pose = space_ == PoseGraphSpace::kSe2
                               ? FromPlanar(Eigen::Map<const Eigen::Vector3d>(block))
                               : Pose::FromBlock(block);
  }
}

}  // namespace highwall::internal
