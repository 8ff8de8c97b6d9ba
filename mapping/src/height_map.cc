#include <highwall/mapping/height_map.h>

#include <cmath>

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

}  // namespace highwall
