#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <highwall/internal/worker_team.h>
#include <octomap/OcTree.h>

#include "voxel_brick.h"

namespace highwall::internal {

// OctoMap's octree with an update by whole scans: one walk down the tree per scan, every inner node
// above a change is updated, and its equal children merged, exactly once on the way back. A region
// that the scan covers evenly is updated as one node, without splitting it.
class ScanOctree final : public octomap::OcTree {
 public:
  using octomap::OcTree::OcTree;

  // bricks: in Morton order, each with some bit set, free or occupied. Subtrees are shared out to
  // the team. helpers: for each of its workers but the first an empty tree, which lends its
  // allocation and its count of nodes.
  void Apply(std::span<VoxelBrick* const> bricks, std::span<ScanOctree> helpers, WorkerTeam& team);
  // Puts in the place of each brick what `source` holds there, be it nothing. mortons: of the
  // bricks, ascending, each once.
  void ReplaceBricks(std::span<const std::uint64_t> mortons, const ScanOctree& source);

 private:
  // created: the node was made by this scan and holds no value yet; a node without children that
  // is not, is a leaf that stands for all voxels below.
  struct Subtree {
    octomap::OcTreeNode* node = nullptr;
    bool created = false;
    unsigned depth = 0;
    std::span<VoxelBrick* const> bricks;
  };
  void ApplyBricks(const Subtree& subtree);
  // Opens the nodes that more than `limit` bricks lie below, and lists them, children first, and
  // the subtrees under them. Both then wait: the subtrees for their bricks, the nodes for Close().
  void Split(const Subtree& subtree, std::size_t limit, std::vector<Subtree>& subtrees,
             std::vector<octomap::OcTreeNode*>& opened);
  // Calls visit(child) for the children that bricks lie below, made where there are none. False if
  // the bricks do not change the node, as a whole.
  template <typename Visit>
  bool VisitChildren(const Subtree& subtree, const Visit& visit);
  void ApplyBrick(octomap::OcTreeNode* node, bool created, const VoxelBrick& brick);
  // The 8, 64 or 1 voxels (`width` bits) below a node.
  void ApplyBits(octomap::OcTreeNode* node, bool created, unsigned width, std::uint64_t free,
                 std::uint64_t occupied);
  // True if the leaf sits at the clamping limits that the update pushes against.
  bool IsSaturated(const octomap::OcTreeNode* leaf, bool any_free, bool any_occupied) const;
  octomap::OcTreeNode* Child(octomap::OcTreeNode* node, unsigned i, bool& created);
  void Close(octomap::OcTreeNode* inner);
  // created: as above. from: what `source` holds at the same place, null for nothing. False if
  // nothing is left of the node.
  bool Replace(octomap::OcTreeNode* node, bool created, unsigned depth,
               std::span<const std::uint64_t> mortons, const ScanOctree& source,
               const octomap::OcTreeNode* from);
  void Copy(const ScanOctree& source, const octomap::OcTreeNode* from, octomap::OcTreeNode* to);
  // Turns an inner node into a leaf, of no value.
  void RemoveChildren(octomap::OcTreeNode* node);
};

}  // namespace highwall::internal
