#include <highwall/mapping/color_octree.h>

#include <cmath>
#include <string>

#include <octomap/ColorOcTree.h>

#include <highwall/core/atomic_file.h>
#include <highwall/internal/number_text.h>

#include "voxel_filter.h"

namespace highwall {
namespace {

class ColorTree final : public octomap::ColorOcTree {
 public:
  using octomap::ColorOcTree::ColorOcTree;

  // Adds occupied leaves voxel by voxel, since each voxel has its own colour: equal ones are merged
  // at the end.
  void Add(const OctreeLeaf& leaf) {
    const int n = static_cast<int>(std::lround(leaf.size / resolution));
    const int cells = leaf.occupied ? n : 1;
    const double step = leaf.size / cells;
    const Eigen::Vector3d first =
        leaf.center_W - Eigen::Vector3d::Constant(0.5 * step * (cells - 1));
    const auto depth = tree_depth - static_cast<unsigned>(std::lround(std::log2(n / cells)));
    for (int i = 0; i < cells * cells * cells; ++i) {
      const Eigen::Vector3d cell(i % cells, i / cells % cells, i / (cells * cells));
      NodeAt(first + step * cell, depth)->setLogOdds(leaf.log_odds);
    }
  }

 private:
  // Returns the node, created with its ancestors if it does not exist.
  octomap::ColorOcTreeNode* NodeAt(const Eigen::Vector3d& p, unsigned depth) {
    const octomap::OcTreeKey key = coordToKey(p.x(), p.y(), p.z());
    if (root == nullptr) {
      root = new octomap::ColorOcTreeNode();  // owned, and deleted, by the base class
      ++tree_size;
    }
    octomap::ColorOcTreeNode* node = root;
    for (unsigned level = 0; level < depth; ++level) {
      const unsigned i = octomap::computeChildIdx(key, static_cast<int>(tree_depth - 1 - level));
      node = nodeChildExists(node, i) ? getNodeChild(node, i) : createNodeChild(node, i);
    }
    return node;
  }
};

}  // namespace

void WriteColorOctree(const std::filesystem::path& path, const OctomapBuilder& map,
                      std::span<const ColoredPoint> points_W) {
  const double resolution = map.options().resolution;
  ColorTree tree(resolution);
  tree.setClampingThresMin(map.options().clamp_min);
  tree.setClampingThresMax(map.options().clamp_max);
  tree.setOccupancyThres(map.options().occupancy_threshold);
  map.ForEachLeaf([&](const OctreeLeaf& leaf) { tree.Add(leaf); });
  internal::VoxelFilter colours(resolution);
  for (const ColoredPoint& point : points_W) colours.Add(point);
  for (const ColoredPoint& mean : colours.Points()) {
    octomap::ColorOcTreeNode* const node = tree.search(mean.p.x(), mean.p.y(), mean.p.z());
    if (node != nullptr && tree.isNodeOccupied(node)) {
      node->setColor(mean.rgb[0], mean.rgb[1], mean.rgb[2]);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();

  AtomicFile file(path);
  file.stream() << "# Octomap OcTree file\nid ColorOcTree\nsize " << std::to_string(tree.size())
                << "\nres " << NumberText(resolution) << "\ndata\n";
  tree.writeData(file.stream());
  file.Commit();
}

}  // namespace highwall
