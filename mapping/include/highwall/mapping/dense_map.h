#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/mapping/colored_point.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>

namespace highwall {

// What is made of depth images and their poses.
struct DenseMap {
  std::vector<ColoredPoint> cloud;  // in W
  OctomapBuilder octree;
  OccupancyGrid grid;
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // to the frame of the grid, z up
  std::optional<double> ground_height;                       // [m] in G
  double merge_ms = 0.0, octree_ms = 0.0;                    // what both took in the end
};

// Estimates up and the ground from the octree, and fills grid, R_GW and ground_height. cameras:
// T_WC of those that saw the map, at least one. level: z of W points up (a sensor with IMU, a
// surveyed trajectory); else a plane is fitted below the cameras.
void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense);

}  // namespace highwall
