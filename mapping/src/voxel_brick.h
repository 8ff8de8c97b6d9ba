#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "key_index.h"

namespace highwall::internal {

constexpr int kKeyOffset = 32768;  // voxel at the origin of W, as in OctoMap

// Bits of a Morton index that belong to x; those of y and z follow to the left.
constexpr std::uint64_t kMortonMaskX = 0x249249249249;

// Spreads 16 bits to every third position.
inline std::uint64_t Spread(int k) {
  auto bits = static_cast<std::uint64_t>(k);
  bits = (bits | bits << 16) & 0x0000FF0000FF;
  bits = (bits | bits << 8) & 0x00F00F00F00F;
  bits = (bits | bits << 4) & 0x0C30C30C30C3;
  return (bits | bits << 2) & kMortonMaskX;
}

// Returns the path of a voxel from the root of the octree, three bits per level, x lowest.
inline std::uint64_t Morton(const std::array<int, 3>& k) {
  return Spread(k[0]) | Spread(k[1]) << 1 | Spread(k[2]) << 2;
}

// Returns the voxel of a brick with the lowest coordinate along each axis. morton: of the brick.
std::array<int, 3> FirstVoxel(std::uint64_t morton);

// 8^3 bits, one per voxel of the subtree of an octree node three levels above the leaves. Bit i of
// word w is the voxel with Morton index 64 w + i: a word is a subtree of two levels, a byte one of
// one level.
struct VoxelBits {
  std::array<std::uint64_t, 8> words{};

  // Sets a bit. voxel: Morton index, of which the lowest nine bits are used. Returns whether the
  // bit was unset.
  bool Set(std::uint64_t voxel) {
    std::uint64_t& word = words[voxel >> 6 & 7u];
    const std::uint64_t bit = std::uint64_t{1} << (voxel & 63u);
    const bool fresh = (word & bit) == 0;
    word |= bit;
    return fresh;
  }
};

// Update of a brick by a scan. It has cache lines of its own, as the rays write only `free`.
struct alignas(64) VoxelBrick {
  VoxelBits free;
  VoxelBits occupied;
  VoxelBits far;             // occupied, but observed from beyond the far range
  VoxelBits seen;            // contains an endpoint, whether in range or not
  std::uint64_t morton = 0;  // 39 bits, the path from the root
  bool any_occupied = false;
  bool any_free = false;
  bool any_far = false;

  // Makes the sets disjoint: hits take precedence over misses, near hits over far ones.
  void Finish();
  // Keeps only the far hits, as hits.
  void KeepFarHits();
};

// Bricks that a scan touches, in the order of the first touch.
class BrickTable {
 public:
  BrickTable() : slots_(kSlots) {}

  // Removes the bricks and keeps the memory.
  void Clear();
  // Returns the brick of a voxel, created if it is new. voxel: its Morton index. The reference is
  // valid until the next call.
  VoxelBrick& BrickOf(std::uint64_t voxel) {
    const std::uint64_t morton = voxel >> 9;
    const Slot slot = slots_[morton % kSlots];
    if (slot.tag == morton / kSlots) [[likely]]
      return bricks_[slot.index];
    return bricks_[Find(morton)];
  }
  std::span<VoxelBrick> bricks() { return bricks_; }

 private:
  // Cache in front of the index: the low bits of a Morton code repeat every 64 bricks along each
  // axis, which is more than most scans span.
  static constexpr std::uint64_t kSlots = std::uint64_t{1} << 18;
  struct Slot {
    std::uint32_t tag = ~std::uint32_t{0};
    std::uint32_t index = 0;
  };

  std::uint32_t Find(std::uint64_t morton);

  std::vector<Slot> slots_;
  KeyIndex index_;
  std::vector<VoxelBrick> bricks_;
};

}  // namespace highwall::internal
