#include "voxel_filter.h"

#include <cmath>
#include <string>

#include <highwall/core/error.h>

namespace highwall {
namespace internal {

VoxelFilter::VoxelFilter(double voxel_size) : inverse_size_(1.0 / voxel_size) {
  HIGHWALL_REQUIRE(voxel_size > 0.0 && std::isfinite(inverse_size_),
                   "voxel_size must be positive, is " + std::to_string(voxel_size));
}

void VoxelFilter::Add(const Eigen::Vector3f& p, const std::array<std::uint8_t, 3>& rgb) {
  constexpr double kLimit = 1 << 20;
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const double k = std::floor(p[i] * inverse_size_) + kLimit;
    if (!(k >= 0.0 && k < 2.0 * kLimit)) return;
    key = (key << 21) | static_cast<std::uint64_t>(k);
  }
  const std::uint32_t voxel = index_.Insert(key);
  if (voxel == sums_.size()) sums_.emplace_back();
  Sum& sum = sums_[voxel];
  sum.p += p.cast<double>();
  for (std::size_t i = 0; i < 3; ++i) sum.rgb[i] += rgb[i];
  ++sum.count;
}

std::vector<ColoredPoint> VoxelFilter::Points() const {
  std::vector<ColoredPoint> points;
  points.reserve(sums_.size());
  for (const Sum& sum : sums_) {
    ColoredPoint& point = points.emplace_back();
    point.p = (sum.p / sum.count).cast<float>();
    for (std::size_t i = 0; i < 3; ++i) {
      point.rgb[i] = static_cast<std::uint8_t>((sum.rgb[i] + sum.count / 2) / sum.count);
    }
  }
  return points;
}

}  // namespace internal

std::vector<ColoredPoint> FilterVoxels(std::span<const ColoredPoint> points, double voxel_size) {
  internal::VoxelFilter filter(voxel_size);
  for (const ColoredPoint& point : points) filter.Add(point.p, point.rgb);
  return filter.Points();
}

}  // namespace highwall
