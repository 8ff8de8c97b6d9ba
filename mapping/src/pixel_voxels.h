#pragma once

#include <vector>

#include <Eigen/Core>

#include "voxel_brick.h"

namespace highwall::internal {

using VoxelKey = std::array<int, 3>;  // as OctoMap's, kKeyOffset at the origin of W

// Voxel of a coordinate [m]; outside of the map (IsInside) where there is none, or for a NaN.
inline int ToVoxel(float coordinate, double inverse_resolution) {
  double scaled = inverse_resolution * static_cast<double>(coordinate);
  scaled = scaled > -kKeyOffset ? scaled : -kKeyOffset;
  scaled = scaled < kKeyOffset ? scaled : kKeyOffset;
  const int truncated = static_cast<int>(scaled);
  return truncated - (scaled < truncated ? 1 : 0) + kKeyOffset;
}

// One voxel of margin, for a ray that oversteps its end.
inline bool IsInside(const VoxelKey& k) {
  return k[0] > 0 && k[1] > 0 && k[2] > 0 && k[0] < 2 * kKeyOffset - 1 &&
         k[1] < 2 * kKeyOffset - 1 && k[2] < 2 * kKeyOffset - 1;
}

// The voxels that the pixels of a depth image fall into, row by row.
class PixelVoxels {
 public:
  // p_W = R_WC (m_x z, m_y z, z) + p_WC for `count` pixels; z below min_depth is no measurement.
  // The voxels inside of the map in the order of pixels, without most repetitions; valid until the
  // next call.
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
