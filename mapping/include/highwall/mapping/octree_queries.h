#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/mapping/octomap_builder.h>

// Spatial queries of a robot on its map.
namespace [[gnu::visibility("default")]] highwall {

// Result of casting a ray.
struct RayHit {
  bool known = true;      // false: the ray ended in unknown space
  Eigen::Vector3d p_W;    // [m] centre of the voxel where it ended
  double distance = 0.0;  // [m] from the origin to that centre
};

// Returns the first voxel along a ray that is occupied or, unless `through_unknown`, unknown; empty
// if there is none up to max_range [m]. Throws InvalidArgument unless everything is finite, the
// direction is not zero and max_range is positive.
std::optional<RayHit> CastRay(const OctomapBuilder& map, const Eigen::Vector3d& origin_W,
                              const Eigen::Vector3d& direction_W, double max_range,
                              bool through_unknown = false);

// Nearest point of occupied space.
struct Obstacle {
  Eigen::Vector3d p_W;    // [m] the nearest point of an occupied leaf
  double distance = 0.0;  // [m] 0 inside
};

// Returns the nearest obstacle within max_distance [m] > 0, exact (to the leaf, not to its centre);
// empty if there is none. The octree is searched best first, so no distance field has to be
// maintained. Throws InvalidArgument as above.
std::optional<Obstacle> NearestObstacle(const OctomapBuilder& map, const Eigen::Vector3d& p_W,
                                        double max_distance);

// Returns the centre of the nearest free voxel within max_distance [m] that shares a face with
// unknown space, a frontier to explore (Yamauchi, "A frontier-based approach for autonomous
// exploration", CIRA 1997). Empty if there is none. Throws InvalidArgument as above.
std::optional<Eigen::Vector3d> NearestFrontier(const OctomapBuilder& map,
                                               const Eigen::Vector3d& p_W, double max_distance);

}  // namespace highwall
