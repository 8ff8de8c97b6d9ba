#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <highwall/internal/worker_team.h>
#include <octomap/OcTree.h>

#include "voxel_brick.h"

namespace highwall::internal {

// OctoMap's octree with an update by whole scans: the tree is traversed once per scan; every inner
// node above a change is updated, and its equal children are merged, exactly once on the way back.
// A region that the scan covers uniformly is updated as one node, without splitting it.
class ScanOctree final : public octomap::OcTree {
 public:
  using octomap::OcTree::OcTree;

  // Applies a scan. bricks: in Morton order, each with some bit set, free or occupied. Subtrees are
  // distributed over the team. helpers: an empty tree for each of its workers except the first,
  // which provides its allocation and its count of nodes.
  void Apply(std::span<VoxelBrick* const> bricks, std::span<ScanOctree> helpers, WorkerTeam& team);
  // Replaces each brick by the content of `source` there, which may be empty. mortons: of the
  // bricks, ascending, each once.
  void ReplaceBricks(std::span<const std::uint64_t> mortons, const ScanOctree& source);

 private:
  // created: the node was created by this scan and has no value yet; a node without children that
  // was not created is a leaf that represents all voxels below it.
  struct Subtree {
    octomap::OcTreeNode* node = nullptr;
    bool created = false;
    unsigned depth = 0;
    std::span<VoxelBrick* const> bricks;
  };
  void ApplyBricks(const Subtree& subtree);
  // Opens the nodes with more than `limit` bricks below them, and lists them, children first, and
  // the subtrees under them. The subtrees then wait for their bricks, the nodes for Close().
  void Split(const Subtree& subtree, std::size_t limit, std::vector<Subtree>& subtrees,
             std::vector<octomap::OcTreeNode*>& opened);
  // Calls visit(child) for the children with bricks below them, which are created if missing.
  // Returns false if the bricks do not change the node as a whole.
  template <typename Visit>
  bool VisitChildren(const Subtree& subtree, const Visit& visit);
  void ApplyBrick(octomap::OcTreeNode* node, bool created, const VoxelBrick& brick);
  // Applies the 64, 8 or 1 voxels (`width` bits) below a node.
  void ApplyBits(octomap::OcTreeNode* node, bool created, unsigned width, std::uint64_t free,
                 std::uint64_t occupied);
  // Returns true if the leaf is at the clamping limits towards which the update would move it.
  bool IsSaturated(const octomap::OcTreeNode* leaf, bool any_free, bool any_occupied) const;
  octomap::OcTreeNode* Child(octomap::OcTreeNode* node, unsigned i, bool& created);
  void Close(octomap::OcTreeNode* inner);
  // created: as above. from: node of `source` at the same place, null if there is none. Returns
  // false if nothing is left of the node.
  bool Replace(octomap::OcTreeNode* node, bool created, unsigned depth,
               std::span<const std::uint64_t> mortons, const ScanOctree& source,
               const octomap::OcTreeNode* from);
  void Copy(const ScanOctree& source, const octomap::OcTreeNode* from, octomap::OcTreeNode* to);
  // Turns an inner node into a leaf without a value.
  void RemoveChildren(octomap::OcTreeNode* node);
};

}  // namespace highwall::internal
