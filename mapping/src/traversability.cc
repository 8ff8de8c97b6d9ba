#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>
#include <highwall/mapping/height_map.h>
#include <highwall/mapping/occupancy_grid.h>

#include "leaf_samples.h"

namespace highwall {
namespace {

// Returns the slope, the norm of the gradient: rise over run along both axes, across +-radius cells
// or the known half of them; 0 if none is known.
double SlopeAt(const HeightMap& ground, int i, int j, int radius) {
  const double here = ground.At(i, j);
  double squares = 0.0;
  for (const auto& [di, dj] : {std::pair{radius, 0}, std::pair{0, radius}}) {
    const double ahead = ground.At(i + di, j + dj), behind = ground.At(i - di, j - dj);
    const double high = std::isnan(ahead) ? here : ahead, low = std::isnan(behind) ? here : behind;
    const int cells = (std::isnan(ahead) ? 0 : radius) + (std::isnan(behind) ? 0 : radius);
    if (cells == 0) continue;
    const double slope = (high - low) / (cells * ground.resolution);
    squares += slope * slope;
  }
  return std::sqrt(squares);
}

double StepAt(const HeightMap& ground, int i, int j) {
  double step = 0.0;
  for (const auto& [di, dj] :
       {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
    const double difference = std::abs(ground.At(i + di, j + dj) - ground.At(i, j));
    if (difference > step) step = difference;  // false for NaN
  }
  return step;
}

}  // namespace

void TraversabilityOptions::Validate() const {
  HIGHWALL_REQUIRE(
      max_slope > 0.0 && max_slope < 90.0,
      "TraversabilityOptions::max_slope must lie in (0, 90), is " + FixedText(max_slope));
  RequirePositive(max_step, "TraversabilityOptions::max_step");
  HIGHWALL_REQUIRE(vehicle_height > max_step,
                   "TraversabilityOptions::vehicle_height must exceed max_step, is " +
                       FixedText(vehicle_height));
  RequirePositive(slope_radius, "TraversabilityOptions::slope_radius");
  HIGHWALL_REQUIRE(R_GW.coeffs().allFinite() && R_GW.norm() > 0.0,
                   "TraversabilityOptions::R_GW must be a rotation");
}

OccupancyGrid TraversabilityGrid(const OctomapBuilder& map, const TraversabilityOptions& options) {
  options.Validate();
  const HeightMap ground = MakeHeightMap(map, HeightSource::kGround, options.R_GW);
  OccupancyGrid grid{.width = ground.width,
                     .height = ground.height,
                     .resolution = ground.resolution,
                     .origin_G = ground.origin_G,
                     .cells = std::vector<GridCell>(ground.z.size(), GridCell::kUnknown)};
  if (ground.z.empty()) return grid;
  const double max_slope = std::tan(options.max_slope * std::numbers::pi / 180.0);
  const int radius =
      std::max(1, static_cast<int>(std::lround(options.slope_radius / ground.resolution)));
  std::size_t cell = 0;
  for (int j = 0; j < grid.height; ++j) {
    for (int i = 0; i < grid.width; ++i, ++cell) {
      if (std::isnan(ground.z[cell])) continue;
      const bool blocked =
          SlopeAt(ground, i, j, radius) > max_slope || StepAt(ground, i, j) > options.max_step;
      grid.cells[cell] = blocked ? GridCell::kOccupied : GridCell::kFree;
    }
  }
  internal::SampleLeaves(
      map, options.R_GW, [&](const OctreeLeaf& leaf, const Eigen::Vector3d& p_G) {
        if (!leaf.occupied) return;
        const Eigen::Vector2d place =
            ((p_G.head<2>() - grid.origin_G) / grid.resolution).array().floor();
        const auto index =
            static_cast<std::size_t>(place.y()) * static_cast<std::size_t>(grid.width) +
            static_cast<std::size_t>(place.x());
        const double above = p_G.z() - ground.z[index];
        if (above > options.max_step && above < options.vehicle_height) {
          grid.cells[index] = GridCell::kOccupied;
        }
      });
  return grid;
}

}  // namespace highwall
