#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <highwall/internal/require.h>
#include <highwall/mapping/keyframe_cloud.h>

#include "kd_tree.h"

namespace highwall {

std::vector<ColoredPoint> RemoveOutliers(std::span<const ColoredPoint> points, int neighbours,
                                         double sigmas) {
  RequireAtLeast(neighbours, 1, "neighbours");
  RequireNotNegative(sigmas, "sigmas");
  std::vector<ColoredPoint> kept;
  std::vector<Eigen::Vector3f> positions;
  for (const ColoredPoint& point : points) {
    if (!point.p.allFinite()) continue;
    kept.push_back(point);
    positions.push_back(point.p);
  }
  if (kept.size() < 2) return kept;
  const internal::KdTree tree(std::move(positions));
  std::vector<double> distances;
  distances.reserve(kept.size());
  std::vector<internal::KdTree::Neighbour> found;
  double sum = 0.0, squares = 0.0;
  for (const ColoredPoint& point : kept) {
    // The first neighbour is the point itself.
    tree.Nearest(point.p, static_cast<std::size_t>(neighbours) + 1, found);
    double distance = 0.0;
    for (const auto& neighbour : found) distance += std::sqrt(neighbour.squared_distance);
    distance /= static_cast<double>(found.size() - 1);
    distances.push_back(distance);
    sum += distance;
    squares += distance * distance;
  }
  const auto count = static_cast<double>(kept.size());
  const double mean = sum / count;
  const double limit = mean + sigmas * std::sqrt(std::max(0.0, squares / count - mean * mean));
  std::size_t i = 0;
  std::erase_if(kept, [&](const ColoredPoint&) { return distances[i++] > limit; });
  return kept;
}

}  // namespace highwall
