#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

// State of a grid cell.
enum class GridCell : std::uint8_t { kUnknown, kFree, kOccupied };

// 2-D map for planning in the frame G (z up, origin that of W). Cell (i, j) covers [origin +
// resolution (i, j), origin + resolution (i + 1, j + 1)): j grows with y.
struct OccupancyGrid {
  int width = 0;                                       // cells along x
  int height = 0;                                      // cells along y
  double resolution = 0.0;                             // [m] per cell
  Eigen::Vector2d origin_G = Eigen::Vector2d::Zero();  // [m] corner of cell (0, 0)
  std::vector<GridCell> cells;                         // cell (i, j) at j * width + i

  GridCell At(int i, int j) const {
    return cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(i)];
  }
  // Returns the cell that contains a point [m]; unknown outside of the grid.
  GridCell Query(const Eigen::Vector2d& p_G) const;
};

// Options of ProjectToGrid().
struct OccupancyGridOptions {
  double z_min = 0.1;          // [m] lower edge of the height band, above the ground
  double z_max = 1.5;          // [m] > z_min, upper edge of the height band
  double ground_height = 0.0;  // [m] of the ground in G; estimated by FloorHeight()
  // Rotation from W to G, for a world whose z axis is not up (RGB-D without IMU); see
  // UprightRotation().
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns the smallest rotation R_GW that maps `up_W` to z. Throws InvalidArgument if up_W is zero
// or not finite.
Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up_W);

// Estimates the height of the floor in G [m]. Among the occupied voxels with free space above them
// (the upper sides of objects), it is the lowest level that holds at least `min_share` times as
// many as the fullest level; a few voxels below the floor (reflections, noise) do not bias it.
// Empty if the map has no such voxel. min_share: (0, 1].
std::optional<double> FloorHeight(const OctomapBuilder& map,
                                  const Eigen::Quaterniond& R_GW = Eigen::Quaterniond::Identity(),
                                  double min_share = 0.3);

// Projects the octree along z, at its own resolution: a cell is occupied where a voxel of the
// height band is, otherwise free where a voxel of the band is known to be free, otherwise unknown.
// The grid covers the known space inside of the band; it is empty (0 x 0) if there is none.
OccupancyGrid ProjectToGrid(const OctomapBuilder& map, const OccupancyGridOptions& options = {});

// Options of TraversabilityGrid().
struct TraversabilityOptions {
  double max_slope = 20.0;      // [deg] (0, 90) that the vehicle can climb
  double max_step = 0.3;        // [m] > 0 that its wheels can cross
  double vehicle_height = 3.0;  // [m] > max_step; higher objects are no obstacles
  double slope_radius = 1.0;    // [m] > 0 to each side, over which the slope is measured
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // as in OccupancyGridOptions

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Computes where a vehicle can drive, on ground that need not be flat: a cell is occupied where the
// ground (the lowest occupied voxel of a column) is too steep, differs from that of a neighbouring
// cell by more than a step, or has an object above it that is lower than the vehicle; free where
// none of this holds; unknown where no ground was observed.
OccupancyGrid TraversabilityGrid(const OctomapBuilder& map,
                                 const TraversabilityOptions& options = {});

// Writes `yaml_path` and, next to it, the image with the extension .pgm, in the format of the
// map_server of ROS and Nav2: binary PGM, trinary (occupied 0, free 254, unknown 205), first row at
// the largest y. Throws InvalidArgument for an empty grid, IoError if a file cannot be written.
void WriteOccupancyGrid(const std::filesystem::path& yaml_path, const OccupancyGrid& grid);

}  // namespace highwall
