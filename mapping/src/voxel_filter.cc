#include "voxel_filter.h"

#include <cmath>
#include <string>

#include <highwall/core/error.h>
#include <highwall/mapping/keyframe_cloud.h>

namespace highwall {
namespace internal {

std::optional<std::uint64_t> VoxelCode(const Eigen::Vector3f& p, double inverse_size) {
  constexpr double kLimit = 1 << 20;
  std::uint64_t code = 0;
  for (int i = 0; i < 3; ++i) {
    const double k = std::floor(p[i] * inverse_size) + kLimit;
    if (!(k >= 0.0 && k < 2.0 * kLimit)) return std::nullopt;
    code = (code << 21) | static_cast<std::uint64_t>(k);
  }
  return code;
}

Eigen::Vector3i VoxelOfCode(std::uint64_t code) {
  constexpr int kLimit = 1 << 20;
  const auto coordinate = [&](int shift) {
    return static_cast<int>(code >> shift & 0x1fffff) - kLimit;
  };
  return {coordinate(42), coordinate(21), coordinate(0)};
}

VoxelFilter::VoxelFilter(double voxel_size) : inverse_size_(1.0 / voxel_size) {
  HIGHWALL_REQUIRE(voxel_size > 0.0 && std::isfinite(inverse_size_),
                   "voxel_size must be positive, is " + std::to_string(voxel_size));
}

void VoxelFilter::Add(const ColoredPoint& point) {
  const std::optional<std::uint64_t> code = VoxelCode(point.p, inverse_size_);
  if (!code) return;
  const std::uint32_t voxel = index_.Insert(*code);
  if (voxel == sums_.size()) sums_.emplace_back();
  Sum& sum = sums_[voxel];
  sum.p += point.p.cast<double>();
  sum.normal += point.normal;
  for (std::size_t i = 0; i < 3; ++i) sum.rgb[i] += point.rgb[i];
  ++sum.count;
}

std::vector<ColoredPoint> VoxelFilter::Points() const {
  std::vector<ColoredPoint> points;
  points.reserve(sums_.size());
  for (const Sum& sum : sums_) {
    ColoredPoint& point = points.emplace_back();
    point.p = (sum.p / sum.count).cast<float>();
    point.normal = sum.normal.stableNormalized();
    for (std::size_t i = 0; i < 3; ++i) {
      point.rgb[i] = static_cast<std::uint8_t>((sum.rgb[i] + sum.count / 2) / sum.count);
    }
  }
  return points;
}

}  // namespace internal

std::vector<ColoredPoint> FilterVoxels(std::span<const ColoredPoint> points, double voxel_size) {
  internal::VoxelFilter filter(voxel_size);
  for (const ColoredPoint& point : points) filter.Add(point);
  return filter.Points();
}

}  // namespace highwall
