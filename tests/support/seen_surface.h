#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

// The surfaces seen by a camera, computed from its true poses and depth.
namespace highwall::testing {

class SeenSurface {
 public:
  using Points = std::vector<Eigen::Vector3d>;  // in W

  // Returns the surface points of an image, on a grid of 60 rows. depth: CV_32FC1 [m], 0 = none.
  static Points PointsOf(const cv::Mat& depth, const PinholeCamera& camera, const Pose& T_WC) {
    constexpr int kRows = 60;
    const int step = std::max(1, depth.rows / kRows);
    Points points;
    for (int v = step / 2; v < depth.rows; v += step) {
      for (int u = step / 2; u < depth.cols; u += step) {
        const double z = depth.at<float>(v, u);
        if (z > 0.0) points.push_back(T_WC * camera.Unproject({u, v}, z));
      }
    }
    return points;
  }

  void Add(const Points& points) {
    for (const Eigen::Vector3d& p_W : points) seen_.insert(Cell(p_W));
  }
  // Adds the cells of the other one.
  void Add(const SeenSurface& other) { seen_.insert(other.seen_.begin(), other.seen_.end()); }

  // Share of the points that lie in a seen cell, [0, 1].
  double ShareSeen(const Points& points) const {
    if (points.empty()) return 0.0;
    std::size_t seen = 0;
    for (const Eigen::Vector3d& p_W : points) seen += seen_.contains(Cell(p_W)) ? 1 : 0;
    return static_cast<double>(seen) / static_cast<double>(points.size());
  }

 private:
  // Larger than the spacing of the grid and the depth noise in a room.
  static constexpr double kCell = 0.15;  // [m]

  static std::uint64_t Cell(const Eigen::Vector3d& p_W) {
    std::uint64_t cell = 0;
    for (int i = 0; i < 3; ++i) {
      const auto steps = static_cast<std::int64_t>(std::floor(p_W[i] / kCell)) + (1 << 20);
      cell = cell << 21 | static_cast<std::uint64_t>(steps);
    }
    return cell;
  }

  std::unordered_set<std::uint64_t> seen_;
};

}  // namespace highwall::testing
