#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

enum class HeightSource {
  kTop,     // the highest occupied voxel of a column: the surface visible from above
  kGround,  // the lowest one: the floor below bridges, roofs and vehicles
};

// Height map over the x-y plane of a frame G (z up, origin that of W), one cell per column of
// voxels. Cell (i, j) covers [origin + resolution (i, j), origin + resolution (i + 1, j + 1)).
struct HeightMap {
  int width = 0;                                       // cells along x
  int height = 0;                                      // cells along y
  double resolution = 0.0;                             // [m] per cell
  Eigen::Vector2d origin_G = Eigen::Vector2d::Zero();  // [m] corner of cell (0, 0)
  std::vector<float> z;  // [m] centre of the voxel, NaN where unknown; cell (i, j) at j * width + i

  // Returns NaN outside of the map.
  float At(int i, int j) const {
    if (i < 0 || j < 0 || i >= width || j >= height) return std::numeric_limits<float>::quiet_NaN();
    return z[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(i)];
  }
};

// Computes the height map of the occupied voxels; empty (0 x 0) if there are none. R_GW: as in
// OccupancyGridOptions.
HeightMap MakeHeightMap(const OctomapBuilder& map, HeightSource source = HeightSource::kTop,
                        const Eigen::Quaterniond& R_GW = Eigen::Quaterniond::Identity());

}  // namespace highwall
