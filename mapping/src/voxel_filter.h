#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <highwall/mapping/point_cloud_io.h>

#include "key_index.h"

namespace highwall::internal {

// 63 bits of a voxel's three coordinates, x highest; empty where the point is not finite or further
// than 2^20 voxels from the origin along an axis.
std::optional<std::uint64_t> VoxelCode(const Eigen::Vector3f& p, double inverse_size);
// The three coordinates of a code.
Eigen::Vector3i VoxelOfCode(std::uint64_t code);

// Mean position, colour and normal per voxel, of points that come one by one.
class VoxelFilter {
 public:
  // voxel_size: [m] > 0, else InvalidArgument.
  explicit VoxelFilter(double voxel_size);

  // False, and nothing is done, where the voxel has `limit` points already or does not exist.
  bool Add(const ColoredPoint& point,
           std::uint32_t limit = std::numeric_limits<std::uint32_t>::max());
  // In the order in which the voxels first occurred.
  std::vector<ColoredPoint> Points() const;
  std::size_t MemoryBytes() const;

 private:
  struct Sum {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    std::array<std::uint32_t, 3> rgb{};
    std::uint32_t count = 0;
  };

  double inverse_size_;
  KeyIndex index_;
  std::vector<Sum> sums_;
};

}  // namespace highwall::internal
