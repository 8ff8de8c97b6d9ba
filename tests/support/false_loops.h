#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose_graph.h>

// Seeded false loops for tests and benchmarks of robust pose graphs.
namespace highwall {

enum class FalseLoopKind {
  kRandom,   // any transform: positions over the extent of the graph, any rotation
  kAliased,  // the transform of some true loop, between unrelated places
};

// Connects random nodes by false loops, whose number is `share` times that of all true loops, with
// the information of true ones. Returns the indices of the new edges.
inline std::vector<std::size_t> AddFalseLoops(double share, FalseLoopKind kind, unsigned seed,
                                              PoseGraph* graph) {
  std::mt19937 rng(seed);
  std::vector<PoseGraphEdge> loops;
  Eigen::Vector3d low = graph->nodes.front().pose.p(), high = low;
  for (const PoseGraphEdge& edge : graph->edges) {
    if (edge.IsLoop()) loops.push_back(edge);
  }
  for (const PoseGraphNode& node : graph->nodes) {
    low = low.cwiseMin(node.pose.p());
    high = high.cwiseMax(node.pose.p());
  }
  const auto pick = [&rng](std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(rng);
  };
  const auto uniform = [&rng] { return std::uniform_real_distribution<double>(-1.0, 1.0)(rng); };
  std::vector<std::size_t> places;
  const auto count = static_cast<std::size_t>(share * static_cast<double>(loops.size()));
  while (places.size() < count) {
    PoseGraphEdge edge = loops[pick(loops.size())];
    edge.i = graph->nodes[pick(graph->nodes.size())].id;
    edge.j = graph->nodes[pick(graph->nodes.size())].id;
    if (std::abs(edge.i - edge.j) <= 1) continue;  // neighbours, which odometry connects
    if (kind == FalseLoopKind::kRandom) {
      const Eigen::Vector3d p =
          (high - low).cwiseProduct(Eigen::Vector3d(uniform(), uniform(), uniform()));
      const bool planar = graph->space == PoseGraphSpace::kSe2;
      const Eigen::Vector3d turn(planar ? 0.0 : uniform(), planar ? 0.0 : uniform(), uniform());
      edge.Z = Pose::FromTangent(p, 3.14 * turn);
    }
    places.push_back(graph->edges.size());
    graph->edges.push_back(edge);
  }
  return places;
}

}  // namespace highwall
