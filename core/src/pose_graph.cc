#include <highwall/core/pose_graph.h>

#include <deque>
#include <numeric>
#include <string>

#include <highwall/core/error.h>
#include "chordal_initialization.h"
#include "planar_pose.h"
#include "pose_graph_problem.h"
#include "pose_graph_topology.h"
#include "pose_information.h"

namespace highwall {
namespace {

using internal::PoseGraphProblem;
using internal::PoseGraphTopology;

// Returns the reason why a pose is invalid; null if it is valid.
const char* ProblemOf(PoseGraphSpace space, const Pose& pose) {
  if (!pose.IsFinite()) return "has a pose that is not finite";
  const bool planar = pose.p().z() == 0.0 && pose.q().x() == 0.0 && pose.q().y() == 0.0;
  if (space == PoseGraphSpace::kSe2 && !planar) return "has a pose that leaves the plane of SE(2)";
  return nullptr;
}

const char* ProblemOf(PoseGraphSpace space, const PoseInformation& information) {
  const Eigen::Index size = space == PoseGraphSpace::kSe2 ? 3 : 6;
  if (information.rows() != size || information.cols() != size) {
    return "has an information matrix of the wrong size";
  }
  if (!information.allFinite()) return "has an information matrix that is not finite";
  const double asymmetry = (information - information.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-9 * information.cwiseAbs().maxCoeff()) {
    return "has an information matrix that is not symmetric";
  }
  if (!internal::IsPositiveSemidefinite(information)) {
    return "has an information matrix that is not positive definite, nor semidefinite";
  }
  return nullptr;
}

void RequirePoses(const PoseGraph& graph) {
  HIGHWALL_REQUIRE(graph.has_poses,
                   "PoseGraph: the graph has no poses to begin with: initialize it from odometry, "
                   "a tree or the chordal relaxation");
}

// Composes poses outwards from the held nodes along the paths with the fewest counted edges.
// free_odometry: odometry is not counted, so that it is followed before any loop.
void ComposeAlongTree(const PoseGraphTopology& topology, bool free_odometry, PoseGraph* graph) {
  struct Step {
    std::size_t node, from, edge;
  };
  std::vector<bool> done = topology.held;
  std::deque<Step> open;
  const auto expand = [&](std::size_t from) {
    for (const auto& [node, edge] : topology.neighbours[from]) {
      if (done[node]) continue;
      if (free_odometry && graph->edges[edge].IsOdometry()) {
        open.push_front({node, from, edge});
      } else {
        open.push_back({node, from, edge});
      }
    }
  };
  for (std::size_t n = 0; n < topology.held.size(); ++n) {
    if (topology.held[n]) expand(n);
  }
  while (!open.empty()) {
    const Step step = open.front();
    open.pop_front();
    if (done[step.node]) continue;
    done[step.node] = true;
    const Pose& Z = graph->edges[step.edge].Z;
    const bool forward = topology.ends[step.edge].j == step.node;
    Pose& pose = graph->nodes[step.node].pose;
    pose = graph->nodes[step.from].pose * (forward ? Z : Z.Inverse());
    // Removes the rounding errors out of the plane.
    if (graph->space == PoseGraphSpace::kSe2) pose = internal::FromPlanar(internal::ToPlanar(pose));
    expand(step.node);
  }
}

}  // namespace

namespace internal {

void RequireValues(const PoseGraph& graph) {
  HIGHWALL_REQUIRE(!graph.edges.empty(), "PoseGraph: the graph has no edges");
  for (const PoseGraphNode& node : graph.nodes) {
    const char* const problem = ProblemOf(graph.space, node.pose);
    HIGHWALL_REQUIRE(problem == nullptr,
                     "PoseGraph: node " + std::to_string(node.id) + " " + problem);
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    const char* problem = ProblemOf(graph.space, edge.Z);
    if (problem == nullptr) problem = ProblemOf(graph.space, edge.information);
    HIGHWALL_REQUIRE(problem == nullptr, "PoseGraph: edge " + std::to_string(edge.i) + " " +
                                             std::to_string(edge.j) + " " + problem);
  }
  HIGHWALL_REQUIRE(graph.factors.empty() || graph.space == PoseGraphSpace::kSe3,
                   "PoseGraph: factors are supported in kSe3 only");
  for (const PoseGraphFactor& factor : graph.factors) {
    HIGHWALL_REQUIRE(factor.cost != nullptr, "PoseGraph: a factor has no cost");
  }
}

}  // namespace internal

void PoseGraph::Validate() const {
  const PoseGraphTopology topology(*this);
  internal::RequireValues(*this);
}

std::vector<double> EdgeChi2(const PoseGraph& graph) {
  const PoseGraphTopology topology(graph);
  internal::RequireValues(graph);
  return internal::EdgeChi2(graph, topology);
}

double Chi2(const PoseGraph& graph) {
  const std::vector<double> chi2 = EdgeChi2(graph);
  return std::accumulate(chi2.begin(), chi2.end(), 0.0);
}

void InitializePoseGraph(PoseGraph* graph, PoseGraphInitialization initialization) {
  const PoseGraphTopology topology(*graph);
  internal::RequireValues(*graph);
  switch (initialization) {
    case PoseGraphInitialization::kGiven:
      RequirePoses(*graph);
      return;
    case PoseGraphInitialization::kOdometry:
      ComposeAlongTree(topology, /*free_odometry=*/true, graph);
      break;
    case PoseGraphInitialization::kTree:
      ComposeAlongTree(topology, /*free_odometry=*/false, graph);
      break;
    case PoseGraphInitialization::kChordal:
      HIGHWALL_REQUIRE(
          graph->factors.empty(),
          "PoseGraph: the chordal relaxation supports edges only, the graph has factors");
      internal::InitializeChordal(topology, graph);
      break;
  }
  graph->has_poses = true;
}

std::optional<Eigen::MatrixXd> PoseGraphCovariance(const PoseGraph& graph,
                                                   std::span<const std::int64_t> ids,
                                                   std::span<const std::size_t> without) {
  const PoseGraphTopology topology(graph);
  internal::RequireValues(graph);
  RequirePoses(graph);
  std::vector<bool> used(graph.edges.size(), true);
  for (const std::size_t edge : without) {
    HIGHWALL_REQUIRE(edge < used.size(),
                     "PoseGraphCovariance: there is no edge " + std::to_string(edge) +
                         " to leave out, the graph has " + std::to_string(used.size()));
    used[edge] = false;
  }
  PoseGraphProblem problem(graph, topology);
  for (std::size_t e = 0; e < used.size(); ++e) {
    if (used[e]) problem.AddEdge(e);
  }
  std::vector<VariableId> wanted;
  for (const std::int64_t id : ids) wanted.push_back(problem.variable(topology.IndexOf(id)));
  return problem.graph().Covariance(wanted);
}

}  // namespace highwall
