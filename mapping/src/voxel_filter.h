#pragma once

#include <cstdint>
#include <vector>

#include <highwall/mapping/dense_cloud.h>

#include "key_index.h"

namespace highwall::internal {

// Mean position and colour per voxel, of points that come one by one.
class VoxelFilter {
 public:
  // voxel_size: [m] > 0, else InvalidArgument.
  explicit VoxelFilter(double voxel_size);

  void Add(const Eigen::Vector3f& p, const std::array<std::uint8_t, 3>& rgb);
  std::vector<ColoredPoint> Points() const;

 private:
  struct Sum {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    std::array<std::uint32_t, 3> rgb{};
    std::uint32_t count = 0;
  };

  double inverse_size_;
  KeyIndex index_;
  std::vector<Sum> sums_;
};

}  // namespace highwall::internal
