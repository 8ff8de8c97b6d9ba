#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <octomap/octomap_types.h>
#include <Eigen/Core>

#include "key_index.h"

namespace highwall::internal {

// 8^3 voxels, the subtree of an octree node three levels above the leaves. Bit i of word w is the
// voxel with Morton index 64 w + i: a word is the subtree two levels up, a byte one level up.
struct VoxelBrick {
  std::uint64_t morton = 0;  // 39 bits, the path from the root
  std::array<std::uint64_t, 8> seen{};
  std::array<std::uint64_t, 8> occupied{};
  std::array<std::uint64_t, 8> free{};
  bool any_occupied = false;
  bool any_free = false;
};

// What one scan says about space: the voxels in which a measurement ends and those that the rays
// to their centres traverse, disjoint (hits win), every voxel once.
class ScanVoxels {
 public:
  // Both [m] > 0; max_range may be infinite.
  ScanVoxels(double resolution, double max_range);

  // Begins a scan; false if the origin lies outside of the map.
  bool Start(const octomap::point3d& origin_W);
  // Endpoints [m] in W; those outside of the map or not finite are dropped.
  void AddPoints(std::span<const Eigen::Vector3f> points_W);
  // Endpoints p_W = R_WC (m_x z, m_y z, z) + p_WC of a row of pixels; z below min_depth is dropped.
  void AddDepthRow(const float* z, const float* m_x, const float* m_y, int count, float min_depth,
                   const Eigen::Matrix3f& R_WC, const Eigen::Vector3f& p_WC);
  // Casts the rays. The bricks with any bit set, in Morton order; valid until Start().
  std::span<const VoxelBrick> Finish();

 private:
  struct Key {
    std::array<int, 3> k;
    bool operator==(const Key&) const = default;
  };

  bool ToKey(const octomap::point3d& p_W, Key& key) const;
  void AddEndpoint(const Key& key);
  octomap::point3d Center(const Key& key) const;
  double CenterCoordinate(int k) const;
  // voxel: its Morton index in the octree.
  VoxelBrick& BrickAt(std::uint64_t voxel);
  // Sets the free bits from the origin up to, not including, the voxel of `end`.
  void CastRay(const octomap::point3d& end);

  double resolution_;
  double inverse_resolution_;
  double max_range_;
  octomap::point3d origin_;
  Key origin_key_{};
  std::array<std::vector<int>, 3> row_keys_;
  std::vector<std::size_t> row_changes_;
  std::vector<Key> endpoints_;
  KeyIndex index_;
  std::uint64_t last_brick_morton_ = 0;
  std::uint32_t last_brick_ = 0;
  std::vector<VoxelBrick> bricks_;
};

}  // namespace highwall::internal
