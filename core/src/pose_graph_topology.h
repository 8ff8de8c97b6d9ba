#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <highwall/core/pose_graph.h>

namespace highwall::internal {

// Connectivity of the nodes of a pose graph, by their indices in PoseGraph::nodes and edges.
struct PoseGraphTopology {
  struct Ends {
    std::size_t i = 0, j = 0;
  };
  struct Neighbour {
    std::size_t node = 0, edge = 0;
  };

  // Throws InvalidArgument for a repeated or negative id, an edge to a missing node or to itself.
  explicit PoseGraphTopology(const PoseGraph& graph);

  // Throws InvalidArgument if there is no such node.
  std::size_t IndexOf(std::int64_t id) const;

  std::unordered_map<std::int64_t, std::size_t> index_of;
  std::vector<Ends> ends;                          // by edge
  std::vector<std::vector<Neighbour>> neighbours;  // by node
  std::vector<std::size_t> component;              // by node
  std::size_t components = 0;
  std::vector<bool> held;  // by node: fixed, or the first of a component without a fixed node
};

// PoseGraph::Validate() except for the checks of PoseGraphTopology.
void RequireValues(const PoseGraph& graph);

}  // namespace highwall::internal
