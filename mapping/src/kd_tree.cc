#include "kd_tree.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace highwall::internal {

KdTree::KdTree(std::vector<Eigen::Vector3f> points) : axes_(points.size()) {
  points_.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    points_.push_back({p, static_cast<std::uint32_t>(points_.size())});
  }
  Build(0, points_.size());
}

void KdTree::Build(std::size_t begin, std::size_t end) {
  if (end - begin < 2) return;
  Eigen::AlignedBox3f box;
  for (std::size_t i = begin; i < end; ++i) box.extend(points_[i].p);
  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Node& a, const Node& b) { return a.p[axis] < b.p[axis]; });
  axes_[middle] = static_cast<std::uint8_t>(axis);
  Build(begin, middle);
  Build(middle + 1, end);
}

template <typename Offer>
void KdTree::Search(std::size_t begin, std::size_t end, const Eigen::Vector3f& p,
                    const Offer& offer, const float& bound) const {
  if (begin == end) return;
  const std::size_t middle = begin + (end - begin) / 2;
  const Node& node = points_[middle];
  offer({(node.p - p).squaredNorm(), node.index});
  const float offset = p[axes_[middle]] - node.p[axes_[middle]];
  const bool below = offset < 0.0f;
  below ? Search(begin, middle, p, offer, bound) : Search(middle + 1, end, p, offer, bound);
  if (offset * offset > bound) return;
  below ? Search(middle + 1, end, p, offer, bound) : Search(begin, middle, p, offer, bound);
}

KdTree::Neighbour KdTree::Nearest(const Eigen::Vector3f& p, float max_distance) const {
  Neighbour best;
  float bound = max_distance * max_distance;
  Search(
      0, points_.size(), p,
      [&](const Neighbour& candidate) {
        if (candidate.squared_distance >= bound) return;
        best = candidate;
        bound = candidate.squared_distance;
      },
      bound);
  return best;
}

void KdTree::Nearest(const Eigen::Vector3f& p, std::size_t k, std::vector<Neighbour>& found) const {
  found.clear();
  const auto nearer = [](const Neighbour& a, const Neighbour& b) {
    return a.squared_distance < b.squared_distance;
  };
  float bound = std::numeric_limits<float>::infinity();
  Search(
      0, points_.size(), p,
      [&](const Neighbour& candidate) {
        if (found.size() == k && candidate.squared_distance >= bound) return;
        if (found.size() == k) {
          std::pop_heap(found.begin(), found.end(), nearer);
          found.pop_back();
        }
        found.push_back(candidate);
        std::push_heap(found.begin(), found.end(), nearer);
        if (found.size() == k) bound = found.front().squared_distance;
      },
      bound);
  std::sort_heap(found.begin(), found.end(), nearer);
}

}  // namespace highwall::internal
