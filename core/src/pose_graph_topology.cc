#include "pose_graph_topology.h"

#include <string>

#include <highwall/core/error.h>

namespace highwall::internal {
namespace {

constexpr std::size_t kNoComponent = static_cast<std::size_t>(-1);

// Nodes that share a factor, by node.
using Partners = std::vector<std::vector<std::size_t>>;

Partners PartnersByFactors(const PoseGraph& graph, const PoseGraphTopology& topology) {
  Partners partners(graph.nodes.size());
  for (const PoseGraphFactor& factor : graph.factors) {
    for (std::size_t i = 1; i < factor.nodes.size(); ++i) {
      const std::size_t a = topology.IndexOf(factor.nodes[i - 1]);
      const std::size_t b = topology.IndexOf(factor.nodes[i]);
      partners[a].push_back(b);
      partners[b].push_back(a);
    }
  }
  return partners;
}

// Marks the nodes that can be reached from `start`.
void FillComponent(std::size_t start, std::size_t name, const Partners& partners,
                   PoseGraphTopology* topology) {
  std::vector<std::size_t> open = {start};
  topology->component[start] = name;
  while (!open.empty()) {
    const std::size_t node = open.back();
    open.pop_back();
    const auto reach = [&](std::size_t next) {
      if (topology->component[next] != kNoComponent) return;
      topology->component[next] = name;
      open.push_back(next);
    };
    for (const auto& [next, edge] : topology->neighbours[node]) reach(next);
    for (const std::size_t next : partners[node]) reach(next);
  }
}

}  // namespace

PoseGraphTopology::PoseGraphTopology(const PoseGraph& graph)
    : neighbours(graph.nodes.size()),
      component(graph.nodes.size(), kNoComponent),
      held(graph.nodes.size(), false) {
  index_of.reserve(graph.nodes.size());
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const std::int64_t id = graph.nodes[n].id;
    HIGHWALL_REQUIRE(id >= 0, "PoseGraph: node id " + std::to_string(id) + " is negative");
    HIGHWALL_REQUIRE(index_of.emplace(id, n).second,
                     "PoseGraph: node " + std::to_string(id) + " is there twice");
  }
  ends.reserve(graph.edges.size());
  for (const PoseGraphEdge& edge : graph.edges) {
    HIGHWALL_REQUIRE(edge.i != edge.j,
                     "PoseGraph: edge from node " + std::to_string(edge.i) + " to itself");
    const Ends e{IndexOf(edge.i), IndexOf(edge.j)};
    neighbours[e.i].push_back({e.j, ends.size()});
    neighbours[e.j].push_back({e.i, ends.size()});
    ends.push_back(e);
  }
  const Partners partners = PartnersByFactors(graph, *this);
  std::vector<bool> has_gauge;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (component[n] == kNoComponent) {
      FillComponent(n, components++, partners, this);
      has_gauge.push_back(false);
    }
    if (graph.nodes[n].fixed) held[n] = has_gauge[component[n]] = true;
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!has_gauge[component[n]]) held[n] = has_gauge[component[n]] = true;
  }
}

std::size_t PoseGraphTopology::IndexOf(std::int64_t id) const {
  const auto found = index_of.find(id);
  HIGHWALL_REQUIRE(found != index_of.end(),
                   "PoseGraph: node " + std::to_string(id) + " is not there");
  return found->second;
}

}  // namespace highwall::internal
