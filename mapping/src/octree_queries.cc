#include <highwall/mapping/octree_queries.h>

#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

#include "octomap_builder_impl.h"

namespace highwall {

// Traverses the nodes of the octree by the distance of their cubes from a point, nearest first.
class OctreeSearch {
 public:
  struct Entry {
    double squared_distance = 0.0;
    const octomap::OcTreeNode* node = nullptr;
    Eigen::Vector3d center;
    double size = 0.0;
    bool operator>(const Entry& other) const { return squared_distance > other.squared_distance; }
  };

  OctreeSearch(const OctomapBuilder& map, const Eigen::Vector3d& p_W, double max_distance)
      : tree_(map.impl_->tree), p_W_(p_W), limit_(max_distance * max_distance) {
    HIGHWALL_REQUIRE(p_W.allFinite(), "the point is not finite");
    RequirePositive(max_distance, "max_distance");
    if (tree_.getRoot() != nullptr) {
      Push(tree_.getRoot(), Eigen::Vector3d::Zero(), tree_.getNodeSize(0));
    }
  }

  const internal::ScanOctree& tree() const { return tree_; }
  // Returns the next leaf, empty at the end; nodes for which `matters` is false are skipped.
  template <typename Matters>
  std::optional<Entry> Next(const Matters& matters) {
    while (!queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (!tree_.nodeHasChildren(entry.node)) return entry;
      const double half = 0.5 * entry.size;
      for (unsigned i = 0; i < 8; ++i) {
        if (!tree_.nodeChildExists(entry.node, i)) continue;
        const octomap::OcTreeNode* const child = tree_.getNodeChild(entry.node, i);
        if (!matters(child)) continue;
        const Eigen::Vector3d side((i & 1u) ? 0.5 : -0.5, (i & 2u) ? 0.5 : -0.5,
                                   (i & 4u) ? 0.5 : -0.5);
        Push(child, entry.center + half * side, half);
      }
    }
    return std::nullopt;
  }
  Eigen::Vector3d NearestPoint(const Entry& entry) const {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * entry.size);
    return p_W_.cwiseMax(entry.center - half).cwiseMin(entry.center + half);
  }

 private:
  void Push(const octomap::OcTreeNode* node, const Eigen::Vector3d& center, double size) {
    Entry entry{.node = node, .center = center, .size = size};
    entry.squared_distance = (NearestPoint(entry) - p_W_).squaredNorm();
    if (entry.squared_distance <= limit_) queue_.push(entry);
  }

  const internal::ScanOctree& tree_;
  Eigen::Vector3d p_W_;
  double limit_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

std::optional<Obstacle> NearestObstacle(const OctomapBuilder& map, const Eigen::Vector3d& p_W,
                                        double max_distance) {
  OctreeSearch search(map, p_W, max_distance);
  // An inner node holds the maximum of its children.
  const auto occupied = [&](const octomap::OcTreeNode* node) {
    return search.tree().isNodeOccupied(node);
  };
  while (const auto leaf = search.Next(occupied)) {
    if (!occupied(leaf->node)) continue;  // only possible for the root
    return Obstacle{search.NearestPoint(*leaf), std::sqrt(leaf->squared_distance)};
  }
  return std::nullopt;
}

std::optional<RayHit> CastRay(const OctomapBuilder& map, const Eigen::Vector3d& origin_W,
                              const Eigen::Vector3d& direction_W, double max_range,
                              bool through_unknown) {
  HIGHWALL_REQUIRE(origin_W.allFinite() && direction_W.allFinite() && !direction_W.isZero(0.0),
                   "a ray needs a finite origin and a direction");
  HIGHWALL_REQUIRE(max_range > 0.0 && std::isfinite(max_range),
                   "max_range must be positive and finite, is " + FixedText(max_range));
  const double resolution = map.options().resolution;
  const Eigen::Vector3d direction = direction_W.normalized();
  Eigen::Vector3d voxel = (origin_W / resolution).array().floor();
  Eigen::Vector3d next, delta;
  for (int i = 0; i < 3; ++i) {
    const bool forward = direction[i] > 0.0;
    next[i] = direction[i] == 0.0
                  ? std::numeric_limits<double>::infinity()
                  : ((voxel[i] + (forward ? 1.0 : 0.0)) * resolution - origin_W[i]) / direction[i];
    delta[i] = resolution / std::abs(direction[i]);
  }
  for (double entered = 0.0; entered <= max_range;) {
    const Eigen::Vector3d center = (voxel.array() + 0.5) * resolution;
    const std::optional<bool> occupied = map.IsOccupied(center);
    if (occupied == true || (!occupied && !through_unknown)) {
      return RayHit{occupied.has_value(), center, (center - origin_W).norm()};
    }
    Eigen::Index axis;
    entered = next.minCoeff(&axis);
    voxel[axis] += direction[axis] > 0.0 ? 1.0 : -1.0;
    next[axis] += delta[axis];
  }
  return std::nullopt;
}

namespace {

// Returns the voxel of the surface of a free leaf nearest to p_W that is adjacent to unknown space.
std::optional<Eigen::Vector3d> FrontierOf(const OctomapBuilder& map,
                                          const OctreeSearch::Entry& leaf,
                                          const Eigen::Vector3d& p_W) {
  const double resolution = map.options().resolution;
  const int n = static_cast<int>(std::lround(leaf.size / resolution));
  const Eigen::Vector3d first = leaf.center - Eigen::Vector3d::Constant(0.5 * resolution * (n - 1));
  std::optional<Eigen::Vector3d> best;
  const auto offer = [&](const Eigen::Vector3d& voxel, const Eigen::Vector3d& outside) {
    if (best && (voxel - p_W).squaredNorm() >= (*best - p_W).squaredNorm()) return;
    if (!map.Occupancy(outside)) best = voxel;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n - 1}) {
      for (int i = 0; i < n * n; ++i) {
        Eigen::Vector3d step;
        step[axis] = side;
        step[(axis + 1) % 3] = i % n;
        step[(axis + 2) % 3] = i / n;
        const Eigen::Vector3d voxel = first + resolution * step;
        Eigen::Vector3d outside = voxel;
        outside[axis] += side == 0 ? -resolution : resolution;
        offer(voxel, outside);
        if (n > 1) continue;
        outside[axis] = voxel[axis] + resolution;
        offer(voxel, outside);
      }
    }
  }
  return best;
}

}  // namespace

std::optional<Eigen::Vector3d> NearestFrontier(const OctomapBuilder& map,
                                               const Eigen::Vector3d& p_W, double max_distance) {
  OctreeSearch search(map, p_W, max_distance);
  std::optional<Eigen::Vector3d> best;
  double best_distance = max_distance;
  while (const auto leaf = search.Next([](const octomap::OcTreeNode*) { return true; })) {
    if (std::sqrt(leaf->squared_distance) > best_distance) break;
    if (search.tree().isNodeOccupied(leaf->node)) continue;
    const auto frontier = FrontierOf(map, *leaf, p_W);
    if (!frontier || (*frontier - p_W).norm() > best_distance) continue;
    best = frontier;
    best_distance = (*frontier - p_W).norm();
  }
  return best;
}

}  // namespace highwall
