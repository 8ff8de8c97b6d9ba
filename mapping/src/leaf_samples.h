#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/mapping/octomap_builder.h>

namespace highwall::internal {

// Calls visit(leaf, p_G) for points of each leaf so that none of its space is skipped. If G and W
// are parallel, these are the centres of its smallest voxels, otherwise points at half that
// distance: a cube of the size of a voxel contains a ball of the diameter of the voxel, and a
// lattice of half that spacing meets every such ball (its largest gap is sqrt(3)/2 of the
// diameter).
template <typename Visit>
void SampleLeaves(const OctomapBuilder& map, const Eigen::Quaterniond& R_GW, const Visit& visit) {
  const double resolution = map.options().resolution;
  const Eigen::Matrix3d R = R_GW.normalized().toRotationMatrix();
  const double spacing =
      R.isApprox(Eigen::Matrix3d::Identity(), 1e-12) ? resolution : 0.5 * resolution;
  map.ForEachLeaf([&](const OctreeLeaf& leaf) {
    const int n = static_cast<int>(std::lround(leaf.size / spacing));
    const Eigen::Vector3d first =
        R * leaf.center_W - R * Eigen::Vector3d::Constant(0.5 * spacing * (n - 1));
    for (int x = 0; x < n; ++x) {
      for (int y = 0; y < n; ++y) {
        for (int z = 0; z < n; ++z) {
          visit(leaf, first + spacing * (R * Eigen::Vector3d(x, y, z)));
        }
      }
    }
  });
}

inline std::int64_t CellIndex(double coordinate, double resolution) {
  return static_cast<std::int64_t>(std::floor(coordinate / resolution));
}

}  // namespace highwall::internal
