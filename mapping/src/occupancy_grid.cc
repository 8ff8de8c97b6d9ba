#include <highwall/mapping/occupancy_grid.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

#include "leaf_samples.h"

namespace highwall {
namespace {

using internal::CellIndex;
using internal::SampleLeaves;

}  // namespace

GridCell OccupancyGrid::Query(const Eigen::Vector2d& p_G) const {
  const Eigen::Vector2d cell = ((p_G - origin_G) / resolution).array().floor();
  const bool inside = cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < width && cell.y() < height;
  return inside ? At(static_cast<int>(cell.x()), static_cast<int>(cell.y())) : GridCell::kUnknown;
}

void OccupancyGridOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(z_min), "OccupancyGridOptions::z_min must be finite");
  HIGHWALL_REQUIRE(z_max > z_min,
                   "OccupancyGridOptions::z_max must exceed z_min, is " + FixedText(z_max));
  HIGHWALL_REQUIRE(std::isfinite(ground_height),
                   "OccupancyGridOptions::ground_height must be finite");
  HIGHWALL_REQUIRE(R_GW.coeffs().allFinite() && R_GW.norm() > 0.0,
                   "OccupancyGridOptions::R_GW must be a rotation");
}

Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up_W) {
  HIGHWALL_REQUIRE(up_W.allFinite() && up_W.norm() > 0.0, "up_W must be a direction");
  return Eigen::Quaterniond::FromTwoVectors(up_W, Eigen::Vector3d::UnitZ());
}

std::optional<double> FloorHeight(const OctomapBuilder& map, const Eigen::Quaterniond& R_GW,
                                  double min_share) {
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0, "min_share must lie in (0, 1]");
  const double resolution = map.options().resolution;
  const Eigen::Matrix3d R = R_GW.normalized().toRotationMatrix();
  const Eigen::Vector3d up_W = R.transpose().col(2);
  // A surface between two voxels may occupy both: the free space is tested two voxels above.
  std::map<std::int64_t, int> levels;
  map.ForEachLeaf([&](const OctreeLeaf& leaf) {
    if (!leaf.occupied) return;
    const Eigen::Vector3d above_W = leaf.center_W + (0.5 * leaf.size + 1.5 * resolution) * up_W;
    if (map.IsOccupied(above_W) != false) return;
    ++levels[CellIndex((R * leaf.center_W).z(), resolution)];
  });
  // Neighbouring levels are counted together: the floor may be split between two of them.
  const auto count_at = [&](std::int64_t level) {
    const auto found = levels.find(level);
    return found == levels.end() ? 0 : found->second;
  };
  const auto weight = [&](std::int64_t level) {
    return count_at(level - 1) + count_at(level) + count_at(level + 1);
  };
  // An empty level between two full ones is not a floor, although both are its neighbours.
  const auto weight_of_full = [&](std::int64_t level) {
    return levels.contains(level) ? weight(level) : 0;
  };
  int fullest = 0;
  for (const auto& [level, count] : levels) fullest = std::max(fullest, weight(level));
  for (const auto& [level, count] : levels) {
    const bool peak =
        weight(level) >= weight_of_full(level - 1) && weight(level) >= weight_of_full(level + 1);
    if (!peak || weight(level) < min_share * fullest) continue;
    const double shift = count_at(level + 1) - count_at(level - 1);
    return (static_cast<double>(level) + 0.5 + shift / weight(level)) * resolution;
  }
  return std::nullopt;
}

OccupancyGrid ProjectToGrid(const OctomapBuilder& map, const OccupancyGridOptions& options) {
  options.Validate();
  OccupancyGrid grid;
  grid.resolution = map.options().resolution;
  const double low = options.ground_height + options.z_min;
  const double high = options.ground_height + options.z_max;
  using Index = Eigen::Matrix<std::int64_t, 2, 1>;
  const auto cell_of = [&](const Eigen::Vector3d& p_G) {
    return Index(CellIndex(p_G.x(), grid.resolution), CellIndex(p_G.y(), grid.resolution));
  };
  Eigen::AlignedBox<std::int64_t, 2> box;
  SampleLeaves(map, options.R_GW, [&](const OctreeLeaf&, const Eigen::Vector3d& p_G) {
    if (p_G.z() >= low && p_G.z() <= high) box.extend(cell_of(p_G));
  });
  if (box.isEmpty()) return grid;

  grid.width = static_cast<int>(box.sizes().x() + 1);
  grid.height = static_cast<int>(box.sizes().y() + 1);
  grid.origin_G = box.min().cast<double>() * grid.resolution;
  grid.cells.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  SampleLeaves(map, options.R_GW, [&](const OctreeLeaf& leaf, const Eigen::Vector3d& p_G) {
    if (!(p_G.z() >= low && p_G.z() <= high)) return;
    const Index cell = cell_of(p_G) - box.min();
    GridCell& target = grid.cells[static_cast<std::size_t>(cell.y() * grid.width + cell.x())];
    target = std::max(target, leaf.occupied ? GridCell::kOccupied : GridCell::kFree);
  });
  return grid;
}

}  // namespace highwall
