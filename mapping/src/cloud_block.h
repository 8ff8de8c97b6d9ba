#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <highwall/mapping/point_cloud_io.h>

namespace highwall::internal {

// Merged points of a cube of kEdge^3 voxels: sums per voxel, of 36 bytes each plus some 8 of a hash
// table (open addressing, linear probing).
class CloudBlock {
 public:
  static constexpr int kEdge = 64;                 // [voxels]
  static constexpr std::uint32_t kMaxCount = 256;  // points per voxel, for 16-bit colour sums

  CloudBlock() : slots_(kFirstSlots) {}

  // Adds a point. p: relative to the corner of the block, in voxels. Returns false without a change
  // if its voxel already has `limit` points. limit: [1, kMaxCount].
  bool Add(const Eigen::Vector3f& p, const ColoredPoint& point, std::uint32_t limit);
  // Appends one point per voxel, in the order in which the voxels first occurred. corner_W [m].
  void AppendPoints(const Eigen::Vector3d& corner_W, double voxel_size,
                    std::vector<ColoredPoint>& points) const;
  std::size_t size() const { return sums_.size(); }
  std::size_t MemoryBytes() const;

 private:
  static constexpr std::size_t kFirstSlots = 64;
  struct Sum {
    std::uint32_t voxel = 0;
    Eigen::Vector3f p = Eigen::Vector3f::Zero();  // [voxels]
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    std::array<std::uint16_t, 3> rgb{};
    std::uint16_t count = 0;
  };

  std::size_t Home(std::uint32_t voxel) const {
    return (voxel * 0x9E3779B1u >> 8) & (slots_.size() - 1);  // Fibonacci hashing
  }
  Sum& SumOf(std::uint32_t voxel);
  void Grow();

  std::vector<std::uint32_t> slots_;  // 1 + index in sums_; 0: free
  std::vector<Sum> sums_;
};

}  // namespace highwall::internal
