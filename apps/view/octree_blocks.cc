#include "view/octree_blocks.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "view/scene_text.h"

namespace highwall::apps {
namespace {

constexpr int kSideBits = 4;  // of OctreeBlocks::kSide
constexpr int kShare = 50;

std::string PrefixOf(std::int32_t world) {
  return "octree/" + std::to_string(world) + "/";
}

}  // namespace

std::map<OctreeBlocks::Corner, OctreeBlocks::Cells> OctreeBlocks::CubesOf(
    const OctomapBuilder& octree, int level) const {
  const double resolution = octree.options().resolution;
  std::map<Corner, Cells> cubes;
  std::size_t count = 0;
  const auto add = [&](int x, int y, int z) {
    Cells& cells = cubes[{x >> kSideBits, y >> kSideBits, z >> kSideBits}];
    const auto in = [](int value) { return static_cast<std::size_t>(value & (kSide - 1)); };
    const std::size_t index = in(x) + kSide * (in(y) + kSide * in(z));
    if (!cells[index]) ++count;
    cells.set(index);
  };
  octree.ForEachLeaf([&](const OctreeLeaf& leaf) {
    if (!leaf.occupied || count > max_cells_) return;
    const auto first = [&](int k) {
      return static_cast<int>(std::lround((leaf.center_W[k] - 0.5 * leaf.size) / resolution));
    };
    const Corner low = {first(0), first(1), first(2)};
    const int width = static_cast<int>(std::lround(leaf.size / resolution));
    const auto last = [&](std::size_t k) { return (low[k] + width - 1) >> level; };
    for (int x = low[0] >> level; x <= last(0); ++x) {
      for (int y = low[1] >> level; y <= last(1); ++y) {
        for (int z = low[2] >> level; z <= last(2); ++z) add(x, y, z);
      }
    }
  });
  if (count > max_cells_) cubes.clear();
  return cubes;
}

void OctreeBlocks::Publish(std::int32_t world, double size, const Corner& corner,
                           const Cells& cells) {
  std::vector<std::uint16_t> indices;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i]) indices.push_back(static_cast<std::uint16_t>(i));
  }
  std::string key = PrefixOf(world);
  for (const int c : corner) key += std::to_string(c) + ",";
  hub_.SetBlock(key,
                OctreeBlock(world, size, kSide * Eigen::Vector3i(corner.data()), kSide, indices));
}

void OctreeBlocks::Update(std::int32_t id, const OctomapBuilder& octree) {
  if (octree.NodeCount() == 0) return;
  World& world = worlds_[id];
  std::map<Corner, Cells> cubes = CubesOf(octree, world.level);
  while (cubes.empty() && world.level < 12 && octree.LeafCount().occupied > 0) {
    ++world.level;
    world.cubes.clear();
    hub_.RemoveBlocks(PrefixOf(id));
    cubes = CubesOf(octree, world.level);
  }
  const double size = octree.options().resolution * (1 << world.level);
  for (const auto& [corner, cells] : cubes) {
    const auto before = world.cubes.find(corner);
    if (before == world.cubes.end() || before->second != cells) Publish(id, size, corner, cells);
  }
  for (const auto& [corner, cells] : world.cubes) {
    if (!cubes.contains(corner) && cells.any()) Publish(id, size, corner, {});
  }
  world.cubes = std::move(cubes);
}

void OctreeBlocks::UpdateInTurn(std::int32_t id, const OctomapBuilder& octree) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  if (begin < worlds_[id].next) return;
  Update(id, octree);
  const Clock::time_point end = Clock::now();
  worlds_[id].next = end + kShare * (end - begin);
}

}  // namespace highwall::apps
