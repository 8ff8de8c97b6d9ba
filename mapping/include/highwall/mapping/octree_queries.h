#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/mapping/octomap_builder.h>

// What a robot asks its map.
namespace [[gnu::visibility("default")]] highwall {

// Where a ray ended.
struct RayHit {
  bool known = true;      // false: the ray ended in unknown space
  Eigen::Vector3d p_W;    // [m] centre of the voxel where it ended
  double distance = 0.0;  // [m] from the origin to that centre
};

// The first voxel along a ray that is occupied or, unless `through_unknown`, unknown; empty where
// the ray ends free after max_range [m]. Throws InvalidArgument unless everything is finite, the
// direction is not zero and max_range is positive.
std::optional<RayHit> CastRay(const OctomapBuilder& map, const Eigen::Vector3d& origin_W,
                              const Eigen::Vector3d& direction_W, double max_range,
                              bool through_unknown = false);

// The nearest point of what is occupied.
struct Obstacle {
  Eigen::Vector3d p_W;    // [m] the nearest point of an occupied leaf
  double distance = 0.0;  // [m] 0 inside
};

// The nearest obstacle within max_distance [m] > 0, exact (to the leaf, not to its centre); empty
// where there is none. The octree is searched best first, so no distance field has to be kept.
// Throws InvalidArgument as above.
std::optional<Obstacle> NearestObstacle(const OctomapBuilder& map, const Eigen::Vector3d& p_W,
                                        double max_distance);

// The centre of the nearest free voxel within max_distance [m] that touches unknown space with a
// face: where there is something to explore (Yamauchi, "A frontier-based approach for autonomous
// exploration", CIRA 1997). Empty where there is none. Throws InvalidArgument as above.
std::optional<Eigen::Vector3d> NearestFrontier(const OctomapBuilder& map,
                                               const Eigen::Vector3d& p_W, double max_distance);

}  // namespace highwall
