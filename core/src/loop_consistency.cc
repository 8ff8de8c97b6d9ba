#include "loop_consistency.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include <highwall/internal/median.h>
#include <highwall/internal/se3.h>
#include "pose_graph_topology.h"
#include "pose_information.h"

namespace highwall::internal {
namespace {

// Loops whose ends are at most this many steps apart can confirm each other. Beyond that, odometry
// is too uncertain for the cycle to be informative.
constexpr std::int64_t kReach = 5;

// A transform and the covariance of a small step on its right, [rho | theta].
struct UncertainPose {
  Pose T;
  se3::Matrix6 covariance = se3::Matrix6::Zero();

  UncertainPose Inverse() const {
    const se3::Matrix6 Ad = se3::Adjoint(T);
    return {T.Inverse(), Ad * covariance * Ad.transpose()};
  }
  UncertainPose operator*(const UncertainPose& next) const {
    const se3::Matrix6 Ad = se3::Adjoint(next.T.Inverse());
    return {T * next.T, Ad * covariance * Ad.transpose() + next.covariance};
  }
  // Squared Mahalanobis distance from the identity.
  double Chi2() const {
    const se3::Tangent error = se3::Log(T);
    return error.dot(covariance.ldlt().solve(error));
  }
  // Logarithm of the squared volume of the covariance, up to a constant.
  double Room() const { return covariance.ldlt().vectorD().array().log().sum(); }
};

// Returns the measurement of an edge. The components missing in SE(2) have negligible covariance.
UncertainPose Measured(PoseGraphSpace space, const PoseGraphEdge& edge) {
  UncertainPose measured{edge.Z};
  if (space == PoseGraphSpace::kSe3) {
    measured.covariance = CovarianceOf<6>(edge.information);
    return measured;
  }
  constexpr double kNegligible = 1e-12;
  constexpr int kPlanar[] = {0, 1, 5};  // x, y, rotation about z
  measured.covariance = kNegligible * se3::Matrix6::Identity();
  const Eigen::Matrix3d covariance = CovarianceOf<3>(edge.information);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      measured.covariance(kPlanar[row], kPlanar[column]) = covariance(row, column);
    }
  }
  return measured;
}

// A cycle of two neighbouring loops and its closing error.
struct LoopCycle {
  std::size_t a, b;  // edges
  double chi2;
};

// Returns the place of each node along odometry: consecutive in a chain, and more than kReach apart
// in different chains. Chains and nodes without odometry follow each other by their smallest id,
// and a chain begins with the smaller id of its ends.
std::vector<std::int64_t> PlacesAlongOdometry(const PoseGraph& graph,
                                              const PoseGraphTopology& topology) {
  std::vector<std::vector<std::size_t>> neighbours(graph.nodes.size());
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].IsOdometry()) continue;
    const auto& [i, j] = topology.ends[e];
    const auto connect = [&](std::size_t from, std::size_t to) {
      if (std::ranges::count(neighbours[from], to) == 0) neighbours[from].push_back(to);
    };
    connect(i, j);
    connect(j, i);
  }
  std::vector<std::size_t> by_id(graph.nodes.size());
  std::iota(by_id.begin(), by_id.end(), 0u);
  std::ranges::sort(by_id, {}, [&](std::size_t node) { return graph.nodes[node].id; });
  constexpr std::int64_t kNoPlace = -1;
  std::vector<std::int64_t> places(graph.nodes.size(), kNoPlace);
  std::int64_t place = 0;
  const auto follow_chain = [&](std::size_t start) {
    for (std::optional<std::size_t> node = start; node;) {
      places[*node] = place++;
      const auto next = std::ranges::find(neighbours[*node], kNoPlace,
                                          [&](std::size_t other) { return places[other]; });
      node = next == neighbours[*node].end() ? std::nullopt : std::optional(*next);
    }
    place += kReach;
  };
  // The rest, of which no node is the end of a chain, are rings.
  for (const bool rings : {false, true}) {
    for (const std::size_t node : by_id) {
      if (places[node] == kNoPlace && (rings || neighbours[node].size() < 2)) follow_chain(node);
    }
  }
  return places;
}

// The loops of a graph and its odometry chains.
class LoopPairs {
 public:
  explicit LoopPairs(const PoseGraph& graph) {
    const PoseGraphTopology topology(graph);
    const std::vector<std::int64_t> places = PlacesAlongOdometry(graph, topology);
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const PoseGraphEdge& edge = graph.edges[e];
      const std::int64_t i = places[topology.ends[e].i], j = places[topology.ends[e].j];
      UncertainPose measured = Measured(graph.space, edge);
      if (i > j) measured = measured.Inverse();
      const std::int64_t low = std::min(i, j), high = std::max(i, j);
      if (edge.IsLoop()) {
        loops_.push_back({e, low, high, measured});
      } else if (edge.IsOdometry() && high - low == 1) {
        steps_.insert_or_assign(low, measured);
      }
    }
    std::sort(loops_.begin(), loops_.end(),
              [](const Loop& a, const Loop& b) { return a.low < b.low; });
  }

  // Returns the pairs of loops whose ends are close together.
  std::vector<LoopCycle> Cycles() const {
    std::vector<LoopCycle> cycles;
    for (std::size_t a = 0; a < loops_.size(); ++a) {
      for (std::size_t b = a + 1; b < loops_.size(); ++b) {
        if (loops_[b].low - loops_[a].low > kReach) break;
        if (std::abs(loops_[b].high - loops_[a].high) > kReach) continue;
        const auto cycle = Cycle(loops_[a], loops_[b]);
        if (cycle) cycles.push_back({loops_[a].edge, loops_[b].edge, cycle->Chi2()});
      }
    }
    return cycles;
  }

 private:
  struct Loop {
    std::size_t edge;
    std::int64_t low, high;  // places of its ends along odometry
    UncertainPose measured;  // the pose of high in low
  };

  // Empty if the odometry chain is broken.
  std::optional<UncertainPose> Odometry(std::int64_t from, std::int64_t to) const {
    if (from > to) {
      const auto back = Odometry(to, from);
      return back ? std::make_optional(back->Inverse()) : std::nullopt;
    }
    UncertainPose path;
    for (std::int64_t place = from; place < to; ++place) {
      const auto step = steps_.find(place);
      if (step == steps_.end()) return std::nullopt;
      path = path * step->second;
    }
    return path;
  }

  // Along a, odometry, back along b, odometry.
  std::optional<UncertainPose> Cycle(const Loop& a, const Loop& b) const {
    const auto high = Odometry(a.high, b.high), low = Odometry(b.low, a.low);
    if (!high || !low) return std::nullopt;
    return a.measured * *high * b.measured.Inverse() * *low;
  }

  std::vector<Loop> loops_;
  std::unordered_map<std::int64_t, UncertainPose> steps_;  // from a place to the next
};

// Minimum-variance paths over some edges of a graph at its current poses.
class PathFinder {
 public:
  PathFinder(const PoseGraph& graph, const std::vector<bool>& used)
      : graph_(graph), used_(used), topology_(graph) {
    for (const PoseGraphEdge& edge : graph.edges) {
      measured_.push_back(Measured(graph.space, edge));
      // A radian is weighted like a metre.
      variances_.push_back(measured_.back().covariance.trace());
    }
  }

  const UncertainPose& measured(std::size_t edge) const { return measured_[edge]; }

  // Returns the current pose of j in i with the covariance of the minimum-variance path; empty if
  // no path connects them. The combination of all edges is more certain than any single path.
  std::optional<UncertainPose> Between(std::size_t edge) const {
    const auto& [start, goal] = topology_.ends[edge];
    const std::vector<PoseGraphTopology::Neighbour> next = TowardsGoal(start, goal);
    if (next[start].node == kNone) return std::nullopt;
    UncertainPose path;
    for (std::size_t node = start; node != goal; node = next[node].node) {
      path = path * Step(node, next[node]);
    }
    return path;
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  // Dijkstra's algorithm from the goal to the start: returns the next step from each node.
  std::vector<PoseGraphTopology::Neighbour> TowardsGoal(std::size_t start, std::size_t goal) const {
    using Reached = std::pair<double, std::size_t>;  // variance, node
    std::vector<PoseGraphTopology::Neighbour> next(graph_.nodes.size(), {kNone, kNone});
    std::vector<double> least(graph_.nodes.size(), std::numeric_limits<double>::infinity());
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    least[goal] = 0.0;
    open.emplace(0.0, goal);
    while (!open.empty() && open.top().second != start) {
      const auto [variance, node] = open.top();
      open.pop();
      if (variance > least[node]) continue;
      for (const auto& [neighbour, along] : topology_.neighbours[node]) {
        const double sum = variance + variances_[along];
        if (!used_[along] || sum >= least[neighbour]) continue;
        least[neighbour] = sum;
        next[neighbour] = {node, along};
        open.emplace(sum, neighbour);
      }
    }
    return next;
  }

  UncertainPose Step(std::size_t node, const PoseGraphTopology::Neighbour& to) const {
    UncertainPose step = measured_[to.edge];
    if (topology_.ends[to.edge].i != node) step = step.Inverse();
    step.T = graph_.nodes[node].pose.Inverse() * graph_.nodes[to.node].pose;
    return step;
  }

  const PoseGraph& graph_;
  const std::vector<bool>& used_;
  const PoseGraphTopology topology_;
  std::vector<UncertainPose> measured_;  // by edge
  std::vector<double> variances_;        // by edge
};

// Variance factor of the measurements, at most 1, from the median over the cycles that close.
double VarianceFactor(PoseGraphSpace space, double max_chi2, const std::vector<LoopCycle>& cycles) {
  constexpr std::size_t kEnough = 20;
  const double median_chi2 = space == PoseGraphSpace::kSe2 ? 2.366 : 5.348;
  std::vector<double> closing;
  for (const LoopCycle& cycle : cycles) {
    if (cycle.chi2 < max_chi2) closing.push_back(cycle.chi2);
  }
  if (closing.size() < kEnough) return 1.0;
  return std::min(1.0, UpperMedian(std::move(closing)) / median_chi2);
}

}  // namespace

std::vector<bool> ConfirmedLoops(const PoseGraph& graph, double max_chi2, bool estimate) {
  const std::vector<LoopCycle> cycles = LoopPairs(graph).Cycles();
  const double factor = estimate ? VarianceFactor(graph.space, max_chi2, cycles) : 1.0;
  std::vector<bool> confirmed;
  for (const PoseGraphEdge& edge : graph.edges) confirmed.push_back(!edge.IsLoop());
  for (const LoopCycle& cycle : cycles) {
    if (cycle.chi2 < factor * max_chi2) confirmed[cycle.a] = confirmed[cycle.b] = true;
  }
  return confirmed;
}

std::vector<std::size_t> SurestPlausibleLoops(const PoseGraph& graph, double max_chi2,
                                              const std::vector<bool>& trusted,
                                              const std::vector<bool>& candidates) {
  const PathFinder paths(graph, trusted);
  std::vector<std::pair<double, std::size_t>> plausible;  // room, edge
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!candidates[e]) continue;
    const auto path = paths.Between(e);
    if (!path) {  // nothing contradicts it
      plausible.emplace_back(std::numeric_limits<double>::infinity(), e);
      continue;
    }
    const UncertainPose error = paths.measured(e).Inverse() * *path;
    if (error.Chi2() < max_chi2) plausible.emplace_back(error.Room(), e);
  }
  std::sort(plausible.begin(), plausible.end());
  std::vector<std::size_t> surest;
  for (std::size_t k = 0; 2 * k < plausible.size(); ++k) surest.push_back(plausible[k].second);
  return surest;
}

}  // namespace highwall::internal
