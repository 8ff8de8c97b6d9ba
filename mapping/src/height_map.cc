#include <highwall/mapping/height_map.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

#include "leaf_samples.h"

namespace highwall {

HeightMap MakeHeightMap(const OctomapBuilder& map, HeightSource source,
                        const Eigen::Quaterniond& R_GW) {
  HeightMap heights;
  heights.resolution = map.options().resolution;
  using Index = Eigen::Matrix<std::int64_t, 2, 1>;
  const auto cell_of = [&](const Eigen::Vector3d& p_G) {
    return Index(internal::CellIndex(p_G.x(), heights.resolution),
                 internal::CellIndex(p_G.y(), heights.resolution));
  };
  Eigen::AlignedBox<std::int64_t, 2> box;
  internal::SampleLeaves(map, R_GW, [&](const OctreeLeaf& leaf, const Eigen::Vector3d& p_G) {
    if (leaf.occupied) box.extend(cell_of(p_G));
  });
  if (box.isEmpty()) return heights;

  heights.width = static_cast<int>(box.sizes().x() + 1);
  heights.height = static_cast<int>(box.sizes().y() + 1);
  heights.origin_G = box.min().cast<double>() * heights.resolution;
  heights.z.assign(
      static_cast<std::size_t>(heights.width) * static_cast<std::size_t>(heights.height),
      std::numeric_limits<float>::quiet_NaN());
  internal::SampleLeaves(map, R_GW, [&](const OctreeLeaf& leaf, const Eigen::Vector3d& p_G) {
    if (!leaf.occupied) return;
    const Index cell = cell_of(p_G) - box.min();
    float& z = heights.z[static_cast<std::size_t>(cell.y() * heights.width + cell.x())];
    const auto p_z = static_cast<float>(p_G.z());
    const bool better = source == HeightSource::kTop ? p_z > z : p_z < z;
    if (std::isnan(z) || better) z = p_z;
  });
  return heights;
}

VolumeChange CutAndFill(const HeightMap& before, const HeightMap& after, double threshold) {
  VolumeChange change;
  if (before.z.empty() || after.z.empty()) return change;
  const double resolution = before.resolution;
  HIGHWALL_REQUIRE(
      std::abs(after.resolution - resolution) <= 1e-9 * resolution,
      "the resolutions differ: " + FixedText(resolution) + " and " + FixedText(after.resolution));
  HIGHWALL_REQUIRE(threshold >= 0.0, "threshold must not be negative");
  const Eigen::Vector2d shift = (before.origin_G - after.origin_G) / resolution;
  const Eigen::Vector2i cells = shift.array().round().cast<int>();
  HIGHWALL_REQUIRE((shift - cells.cast<double>()).norm() < 1e-3, "the cells do not coincide");
  const double cell_area = resolution * resolution;
  for (int j = 0; j < before.height; ++j) {
    for (int i = 0; i < before.width; ++i) {
      const double rise = after.At(i + cells.x(), j + cells.y()) - before.At(i, j);
      if (std::isnan(rise)) continue;
      change.area += cell_area;
      if (std::abs(rise) <= threshold) continue;
      (rise > 0.0 ? change.fill : change.cut) += std::abs(rise) * cell_area;
    }
  }
  return change;
}

}  // namespace highwall
