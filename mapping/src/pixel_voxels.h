#pragma once

#include <vector>

#include <Eigen/Core>

#include "voxel_brick.h"

namespace highwall::internal {

using VoxelKey = std::array<int, 3>;  // as OctoMap's, kKeyOffset at the origin of W

// Returns the voxel of a coordinate [m]; one outside of the map (IsInside) if there is none, or for
// a NaN.
inline int ToVoxel(float coordinate, double inverse_resolution) {
  double scaled = inverse_resolution * static_cast<double>(coordinate);
  scaled = scaled > -kKeyOffset ? scaled : -kKeyOffset;
  scaled = scaled < kKeyOffset ? scaled : kKeyOffset;
  const int truncated = static_cast<int>(scaled);
  return truncated - (scaled < truncated ? 1 : 0) + kKeyOffset;
}

// Returns whether a voxel is inside of the map, with a margin of one voxel for a ray that oversteps
// its end.
inline bool IsInside(const VoxelKey& k) {
  return k[0] > 0 && k[1] > 0 && k[2] > 0 && k[0] < 2 * kKeyOffset - 1 &&
         k[1] < 2 * kKeyOffset - 1 && k[2] < 2 * kKeyOffset - 1;
}

// Computes the voxels of the pixels of a depth image, row by row.
class PixelVoxels {
 public:
  // Transforms `count` pixels by p_W = R_WC (m_x z, m_y z, z) + p_WC; z below min_depth is not a
  // measurement. Returns the voxels inside of the map in the order of pixels, without most of the
  // repetitions; valid until the next call.
  const std::vector<VoxelKey>& OfRow(const float* z, const float* m_x, const float* m_y, int count,
                                     float min_depth, const Eigen::Matrix3f& R_WC,
                                     const Eigen::Vector3f& p_WC, double inverse_resolution);

 private:
  std::array<std::vector<int>, 3> keys_;
  std::vector<int> unsure_, changes_;
  std::vector<std::size_t> places_;
  std::vector<VoxelKey> voxels_;
};

}  // namespace highwall::internal
