#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

// What is known of a cell.
enum class GridCell : std::uint8_t { kUnknown, kFree, kOccupied };

// A 2-D map for planning in the frame G (z up, origin that of W). Cell (i, j) covers
// [origin + resolution (i, j), origin + resolution (i + 1, j + 1)): j grows with y.
struct OccupancyGrid {
  int width = 0;                                       // cells along x
  int height = 0;                                      // cells along y
  double resolution = 0.0;                             // [m] a cell
  Eigen::Vector2d origin_G = Eigen::Vector2d::Zero();  // [m] corner of cell (0, 0)
  std::vector<GridCell> cells;                         // cell (i, j) at j * width + i

  GridCell At(int i, int j) const {
    return cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(i)];
  }
  // The cell around a point [m]; unknown outside of the grid.
  GridCell Query(const Eigen::Vector2d& p_G) const;
};

// Of ProjectToGrid().
struct OccupancyGridOptions {
  double z_min = 0.1;          // [m] lower edge of the height band, above the ground
  double z_max = 1.5;          // [m] > z_min, upper edge of the height band
  double ground_height = 0.0;  // [m] of the ground in G; FloorHeight() estimates it
  // G from W, for a world whose z axis is not up (RGB-D without IMU); see UprightRotation().
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The smallest rotation R_GW that turns `up_W` to z. Throws InvalidArgument if up_W is zero or not
// finite.
Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up_W);

// Height in G [m] of the floor: among the voxels that are occupied with free space above them (the
// upper sides of things), the lowest level that holds at least `min_share` as many as the fullest
// level; a few voxels below the floor (reflections, noise) do not pull it down. Empty where the map
// shows no such voxel. min_share: (0, 1].
std::optional<double> FloorHeight(const OctomapBuilder& map,
                                  const Eigen::Quaterniond& R_GW = Eigen::Quaterniond::Identity(),
                                  double min_share = 0.3);

// The octree seen from above, at its own resolution: a cell is occupied where a voxel of the height
// band is, else free where a voxel of the band is known to be free, else unknown. The grid covers
// what is known inside of the band; it is empty (0 x 0) where nothing is.
OccupancyGrid ProjectToGrid(const OctomapBuilder& map, const OccupancyGridOptions& options = {});

// Of TraversabilityGrid().
struct TraversabilityOptions {
  double max_slope = 20.0;      // [deg] (0, 90) that the vehicle climbs
  double max_step = 0.3;        // [m] > 0 that its wheels roll over
  double vehicle_height = 3.0;  // [m] > max_step; what hangs higher is no obstacle
  double slope_radius = 1.0;    // [m] > 0 to each side over which the slope is measured
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // as in OccupancyGridOptions

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Where a vehicle can drive, on ground that need not be flat: a cell is occupied where the ground
// (the lowest occupied voxel of a column) is too steep, differs from that of a neighbouring cell by
// more than a step, or carries something above it that is lower than the vehicle; free where none
// of this holds; unknown where no ground was seen.
OccupancyGrid TraversabilityGrid(const OctomapBuilder& map,
                                 const TraversabilityOptions& options = {});

// Writes `yaml_path` and, beside it, the image with the extension .pgm, as the map_server of ROS
// and Nav2 read them: binary PGM, trinary (occupied 0, free 254, unknown 205), first row at the
// largest y. Throws InvalidArgument for an empty grid, IoError if a file cannot be written.
void WriteOccupancyGrid(const std::filesystem::path& yaml_path, const OccupancyGrid& grid);

}  // namespace highwall
