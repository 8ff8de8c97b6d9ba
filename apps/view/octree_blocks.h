#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>

#include <highwall/mapping/octomap_builder.h>

#include "view/view_hub.h"

namespace highwall::apps {

// Follows the octrees of a run by cubes of cells: a cube is published when its cells have changed.
// The cells of an octree with too many of them are joined, two, four ... in each direction. Not
// thread-safe.
class OctreeBlocks {
 public:
  static constexpr int kSide = 16;                  // cells
  static constexpr std::size_t kMaxCells = 60'000;  // occupied ones of a world

  // hub: must outlive this object.
  explicit OctreeBlocks(ViewHub& hub, std::size_t max_cells = kMaxCells)
      : hub_(hub), max_cells_(max_cells) {}

  // Publishes what has changed in the octree of a world since the last call.
  void Update(std::int32_t world, const OctomapBuilder& octree);
  // The same, at most for a fiftieth of the time: the octree is left out if the last one took long.
  void UpdateInTurn(std::int32_t world, const OctomapBuilder& octree);

 private:
  using Cells = std::bitset<kSide * kSide * kSide>;
  using Corner = std::array<int, 3>;  // in cubes
  struct World {
    int level = 0;  // cells are 2^level voxels wide
    std::map<Corner, Cells> cubes;
    std::chrono::steady_clock::time_point next{};
  };

  // Returns the cubes of occupied cells; empty if there are too many.
  std::map<Corner, Cells> CubesOf(const OctomapBuilder& octree, int level) const;
  void Publish(std::int32_t world, double size, const Corner& corner, const Cells& cells);

  ViewHub& hub_;
  const std::size_t max_cells_;
  std::map<std::int32_t, World> worlds_;
};

}  // namespace highwall::apps
