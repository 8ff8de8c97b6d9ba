#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <octomap/octomap_types.h>
#include <Eigen/Core>

#include "pixel_voxels.h"
#include "ray_batch.h"
#include "voxel_brick.h"

namespace highwall::internal {

// Voxels updated by one scan: those in which a measurement ends and those that the rays to their
// centres traverse, disjoint (hits take precedence), every voxel once.
class ScanVoxels {
 public:
  // All arguments [m] > 0; the ranges may be infinite.
  ScanVoxels(double resolution, double max_range, double far_range);

  // Starts a scan; returns false if the origin is outside of the map.
  bool Start(const octomap::point3d& origin_W);
  // Adds endpoints [m] in W; those outside of the map or not finite are dropped.
  void AddPoints(std::span<const Eigen::Vector3f> points_W);
  // Adds the endpoints p_W = R_WC (m_x z, m_y z, z) + p_WC of a row of pixels; z below min_depth is
  // dropped.
  void AddDepthRow(const float* z, const float* m_x, const float* m_y, int count, float min_depth,
                   const Eigen::Matrix3f& R_WC, const Eigen::Vector3f& p_WC);
  // Returns the voxels of the endpoints so far, each once.
  std::span<const VoxelKey> endpoints() const { return endpoints_; }
  // Sets the bits of endpoints, of this or another part of the same scan, and casts their rays.
  void CastRays(std::span<const VoxelKey> endpoints);
  // Merges another part of the same scan, whose rays have been cast as those of this part have.
  void Merge(ScanVoxels& other);
  // Returns the bricks with any bit set, in Morton order; valid until Start(). Call last.
  std::vector<VoxelBrick*> Finish();

 private:
  void AddEndpoint(const VoxelKey& key);
  double CenterCoordinate(int k) const;
  octomap::point3d Center(const VoxelKey& key) const;
  bool ToKey(const octomap::point3d& p_W, VoxelKey& key) const;
  // Queues the ray from the origin up to, but not including, the voxel of `end`.
  void CastRay(const octomap::point3d& end);

  double resolution_;
  double inverse_resolution_;
  double max_range_;
  double far_range_;
  octomap::point3d origin_;
  VoxelKey origin_key_{};
  PixelVoxels pixels_;
  std::vector<VoxelKey> endpoints_;
  BrickTable bricks_;
  RayBatch rays_{};
  int ray_count_ = 0;
};

}  // namespace highwall::internal
