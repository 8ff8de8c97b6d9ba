#include "kd_tree.h"

#include <algorithm>

namespace highwall::internal {
namespace {

std::size_t Middle(std::size_t begin, std::size_t end) {
  return begin + (end - begin) / 2;
}

}  // namespace

KdTree::KdTree(std::vector<Eigen::Vector3f> points) : boxes_(points.size()) {
  points_.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    points_.push_back({p, static_cast<std::uint32_t>(points_.size())});
  }
  Build(0, points_.size());
}

void KdTree::Build(std::size_t begin, std::size_t end) {
  if (begin == end) return;
  const std::size_t middle = Middle(begin, end);
  Eigen::AlignedBox3f& box = boxes_[middle];
  for (std::size_t i = begin; i < end; ++i) box.extend(points_[i].p);
  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Node& a, const Node& b) { return a.p[axis] < b.p[axis]; });
  Build(begin, middle);
  Build(middle + 1, end);
}

template <typename Offer>
void KdTree::Search(std::size_t begin, std::size_t end, const Eigen::Vector3f& p,
                    const Offer& offer, const float& bound) const {
  const std::size_t middle = Middle(begin, end);
  const Node& node = points_[middle];
  offer({(node.p - p).squaredNorm(), node.index});
  const auto distance = [&](std::size_t from, std::size_t to) {
    return from == to ? std::numeric_limits<float>::infinity()
                      : boxes_[Middle(from, to)].squaredExteriorDistance(p);
  };
  const float below = distance(begin, middle), above = distance(middle + 1, end);
  const auto search_below = [&] {
    if (begin != middle && below <= bound) Search(begin, middle, p, offer, bound);
  };
  const auto search_above = [&] {
    if (middle + 1 != end && above <= bound) Search(middle + 1, end, p, offer, bound);
  };
  if (below <= above) {
    search_below();
    search_above();
  } else {
    search_above();
    search_below();
  }
}

KdTree::Neighbour KdTree::Nearest(const Eigen::Vector3f& p, float max_distance) const {
  Neighbour best;
  float bound = max_distance * max_distance;
  if (points_.empty()) return best;
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
  if (points_.empty()) return;
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
