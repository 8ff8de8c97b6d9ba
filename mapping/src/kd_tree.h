#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace highwall::internal {

// Nearest-neighbour search among points in space: a balanced k-d tree (Bentley, "Multidimensional
// Binary Search Trees Used for Associative Searching", CACM 1975), stored as a permutation of the
// points.
class KdTree {
 public:
  // points: must be finite (not checked).
  explicit KdTree(std::vector<Eigen::Vector3f> points);

  std::size_t size() const { return points_.size(); }

  struct Neighbour {
    float squared_distance = std::numeric_limits<float>::infinity();
    std::uint32_t index = 0;  // in the input points
  };
  // Returns the nearest point; an infinite distance if no point is nearer than max_distance [m].
  Neighbour Nearest(const Eigen::Vector3f& p,
                    float max_distance = std::numeric_limits<float>::infinity()) const;
  // Finds the k nearest points, nearest first; fewer if there are not as many.
  void Nearest(const Eigen::Vector3f& p, std::size_t k, std::vector<Neighbour>& found) const;

 private:
  struct Node {
    Eigen::Vector3f p;
    std::uint32_t index;
  };
  // Searches [begin, end): its middle, the root, before the halves on both sides.
  template <typename Offer>
  void Search(std::size_t begin, std::size_t end, const Eigen::Vector3f& p, const Offer& offer,
              const float& bound) const;
  void Build(std::size_t begin, std::size_t end);

  std::vector<Node> points_;
  // Tight bounding boxes of the points below a root: a query far from all points then skips the
  // subtrees behind the nearest one.
  std::vector<Eigen::AlignedBox3f> boxes_;
};

}  // namespace highwall::internal
