#include "cloud_block.h"

namespace highwall::internal {

CloudBlock::Sum& CloudBlock::SumOf(std::uint32_t voxel) {
  std::size_t slot = Home(voxel);
  for (; slots_[slot] != 0; slot = (slot + 1) & (slots_.size() - 1)) {
    Sum& sum = sums_[slots_[slot] - 1];
    if (sum.voxel == voxel) return sum;
  }
  sums_.emplace_back().voxel = voxel;
  slots_[slot] = static_cast<std::uint32_t>(sums_.size());
  if (4 * sums_.size() > 3 * slots_.size()) Grow();
  return sums_.back();
}

void CloudBlock::Grow() {
  slots_.assign(2 * slots_.size(), 0);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    std::size_t slot = Home(sums_[i].voxel);
    while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::uint32_t>(i + 1);
  }
}

bool CloudBlock::Add(const Eigen::Vector3f& p, const ColoredPoint& point, std::uint32_t limit) {
  // Rounding may have moved p out of the block.
  const Eigen::Vector3i v = p.cast<int>().cwiseMax(0).cwiseMin(kEdge - 1);
  Sum& sum = SumOf(static_cast<std::uint32_t>((v.x() * kEdge + v.y()) * kEdge + v.z()));
  if (sum.count >= limit) return false;
  sum.p += p;
  sum.normal += point.normal;
  for (std::size_t i = 0; i < 3; ++i) {
    sum.rgb[i] = static_cast<std::uint16_t>(sum.rgb[i] + point.rgb[i]);
  }
  ++sum.count;
  return true;
}

void CloudBlock::AppendPoints(const Eigen::Vector3d& corner_W, double voxel_size,
                              std::vector<ColoredPoint>& points) const {
  for (const Sum& sum : sums_) {
    ColoredPoint& point = points.emplace_back();
    const Eigen::Vector3d mean = sum.p.cast<double>() / sum.count;  // [voxels]
    point.p = (corner_W + voxel_size * mean).cast<float>();
    point.normal = sum.normal.stableNormalized();
    for (std::size_t i = 0; i < 3; ++i) {
      point.rgb[i] = static_cast<std::uint8_t>((sum.rgb[i] + sum.count / 2) / sum.count);
    }
  }
}

std::size_t CloudBlock::MemoryBytes() const {
  return slots_.capacity() * sizeof(slots_.front()) + sums_.capacity() * sizeof(Sum);
}

}  // namespace highwall::internal
