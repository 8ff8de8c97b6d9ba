#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace highwall::internal {

// Nearest neighbours among points in space: a balanced k-d tree (Bentley, "Multidimensional Binary
// Search Trees Used for Associative Searching", CACM 1975), stored as a permutation of the points.
class KdTree {
 public:
  // Points must be finite (not checked).
  explicit KdTree(std::vector<Eigen::Vector3f> points);

  std::size_t size() const { return points_.size(); }

  struct Neighbour {
    float squared_distance = std::numeric_limits<float>::infinity();
    std::uint32_t index = 0;  // in the points given
  };
  // An infinite distance if there is no point nearer than max_distance [m].
  Neighbour Nearest(const Eigen::Vector3f& p,
                    float max_distance = std::numeric_limits<float>::infinity()) const;
  // The k nearest, nearest first; fewer if there are not as many.
  void Nearest(const Eigen::Vector3f& p, std::size_t k, std::vector<Neighbour>& found) const;

 private:
  struct Node {
    Eigen::Vector3f p;
    std::uint32_t index;
  };
  // Searches [begin, end), whose middle is the root, in front of the halves to both sides.
  template <typename Offer>
  void Search(std::size_t begin, std::size_t end, const Eigen::Vector3f& p, const Offer& offer,
              const float& bound) const;
  void Build(std::size_t begin, std::size_t end);

  std::vector<Node> points_;
  // Of the points below a root, and no more: a query far from all points then passes over what lies
  // behind the nearest.
  std::vector<Eigen::AlignedBox3f> boxes_;
};

}  // namespace highwall::internal
