#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <highwall/mapping/point_cloud_io.h>

#include "key_index.h"

namespace highwall::internal {

// Returns the 63-bit code of a voxel's three coordinates, x highest; empty if the point is not
// finite or farther than 2^20 voxels from the origin along an axis.
std::optional<std::uint64_t> VoxelCode(const Eigen::Vector3f& p, double inverse_size);
// Returns the three coordinates of a code.
Eigen::Vector3i VoxelOfCode(std::uint64_t code);

// Computes the mean position, colour and normal per voxel of points that are added one by one.
class VoxelFilter {
 public:
  // Throws InvalidArgument unless voxel_size [m] is positive.
  explicit VoxelFilter(double voxel_size);

  // Adds a point; does nothing if its voxel does not exist.
  void Add(const ColoredPoint& point);
  // Returns the means in the order in which the voxels first occurred.
  std::vector<ColoredPoint> Points() const;

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
