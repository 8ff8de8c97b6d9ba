#include "scan_octree.h"

#include <algorithm>

namespace highwall::internal {
namespace {
constexpr unsigned kBrickDepth = 13;  // of 16: a brick is three levels high
}

void ScanOctree::Apply(std::span<VoxelBrick* const> bricks) {
  if (bricks.empty()) return;
  const bool created = root == nullptr;
  if (created) {
    root = new octomap::OcTreeNode();  // owned, and deleted, by the base class
    ++tree_size;
  }
  size_changed = true;
  ApplyBricks(root, created, 0, bricks);
}

void ScanOctree::ApplyBricks(octomap::OcTreeNode* node, bool created, unsigned depth,
                             std::span<VoxelBrick* const> bricks) {
  if (depth == kBrickDepth) return ApplyBrick(node, created, *bricks.front());
  if (!created && !nodeHasChildren(node)) {
    const bool any_free = std::ranges::any_of(bricks, [](auto* brick) { return brick->any_free; });
    const bool any_occupied =
        std::ranges::any_of(bricks, [](auto* brick) { return brick->any_occupied; });
    if (IsSaturated(node, any_free, any_occupied)) return;
    expandNode(node);
  }
  const unsigned shift = 3 * (kBrickDepth - 1 - depth);
  while (!bricks.empty()) {
    const std::uint64_t prefix = bricks.front()->morton >> shift;
    const auto end = std::ranges::find_if(
        bricks, [&](const VoxelBrick* brick) { return brick->morton >> shift != prefix; });
    const auto count = static_cast<std::size_t>(end - bricks.begin());
    bool child_created = false;
    octomap::OcTreeNode* const child =
        Child(node, static_cast<unsigned>(prefix & 7u), child_created);
    ApplyBricks(child, child_created, depth + 1, bricks.first(count));
    bricks = bricks.subspan(count);
  }
  Close(node);
}

void ScanOctree::ApplyBrick(octomap::OcTreeNode* node, bool created, const VoxelBrick& brick) {
  if (!created && !nodeHasChildren(node)) {
    if (IsSaturated(node, brick.any_free, brick.any_occupied)) return;
    expandNode(node);
  }
  for (unsigned i = 0; i < 8; ++i) {
    if ((brick.free.words[i] | brick.occupied.words[i]) == 0) continue;
    bool child_created = false;
    octomap::OcTreeNode* const child = Child(node, i, child_created);
    ApplyBits(child, child_created, 64, brick.free.words[i], brick.occupied.words[i]);
  }
  Close(node);
}

void ScanOctree::ApplyBits(octomap::OcTreeNode* node, bool created, unsigned width,
                           std::uint64_t free, std::uint64_t occupied) {
  if (!nodeHasChildren(node)) {
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - width);
    if (free == all || occupied == all) {
      octomap::OcTree::updateNodeLogOdds(node, free == all ? prob_miss_log : prob_hit_log);
      return;
    }
    if (!created) {
      if (IsSaturated(node, free != 0, occupied != 0)) return;
      expandNode(node);
    }
  }
  const unsigned child_width = width / 8;
  const std::uint64_t child_mask = ~std::uint64_t{0} >> (64 - child_width);
  for (unsigned i = 0; i < 8; ++i) {
    const std::uint64_t child_free = free >> (i * child_width) & child_mask;
    const std::uint64_t child_occupied = occupied >> (i * child_width) & child_mask;
    if ((child_free | child_occupied) == 0) continue;
    bool child_created = false;
    octomap::OcTreeNode* const child = Child(node, i, child_created);
    ApplyBits(child, child_created, child_width, child_free, child_occupied);
  }
  Close(node);
}

bool ScanOctree::IsSaturated(const octomap::OcTreeNode* leaf, bool any_free,
                             bool any_occupied) const {
  return (!any_free || leaf->getLogOdds() <= clamping_thres_min) &&
         (!any_occupied || leaf->getLogOdds() >= clamping_thres_max);
}

octomap::OcTreeNode* ScanOctree::Child(octomap::OcTreeNode* node, unsigned i, bool& created) {
  created = !nodeChildExists(node, i);
  return created ? createNodeChild(node, i) : getNodeChild(node, i);
}

void ScanOctree::Close(octomap::OcTreeNode* inner) {
  if (!pruneNode(inner)) inner->updateOccupancyChildren();
}

void ScanOctree::ReplaceBricks(std::span<const std::uint64_t> mortons, const ScanOctree& source) {
  if (mortons.empty() || (root == nullptr && source.root == nullptr)) return;
  const bool created = root == nullptr;
  if (created) {
    root = new octomap::OcTreeNode();  // owned, and deleted, by the base class
    ++tree_size;
  }
  size_changed = true;
  if (!Replace(root, created, 0, mortons, source, source.root)) clear();
}

bool ScanOctree::Replace(octomap::OcTreeNode* node, bool created, unsigned depth,
                         std::span<const std::uint64_t> mortons, const ScanOctree& source,
                         const octomap::OcTreeNode* from) {
  if (depth == kBrickDepth) {
    RemoveChildren(node);
    if (from != nullptr) Copy(source, from, node);
    return from != nullptr;
  }
  if (!created && !nodeHasChildren(node)) expandNode(node);
  const bool from_leaf = from != nullptr && !source.nodeHasChildren(from);
  const unsigned shift = 3 * (kBrickDepth - 1 - depth);
  while (!mortons.empty()) {
    const std::uint64_t prefix = mortons.front() >> shift;
    const auto end = std::ranges::find_if(
        mortons, [&](std::uint64_t morton) { return morton >> shift != prefix; });
    const auto group = mortons.first(static_cast<std::size_t>(end - mortons.begin()));
    mortons = mortons.subspan(group.size());
    const auto i = static_cast<unsigned>(prefix & 7u);
    const octomap::OcTreeNode* child_from = from_leaf ? from : nullptr;
    if (from != nullptr && !from_leaf && source.nodeChildExists(from, i)) {
      child_from = source.getNodeChild(from, i);
    }
    if (child_from == nullptr && !nodeChildExists(node, i)) continue;
    bool child_created = false;
    octomap::OcTreeNode* const child = Child(node, i, child_created);
    if (!Replace(child, child_created, depth + 1, group, source, child_from)) {
      deleteNodeChild(node, i);
    }
  }
  if (!nodeHasChildren(node)) {
    RemoveChildren(node);
    return false;
  }
  Close(node);
  return true;
}

void ScanOctree::Copy(const ScanOctree& source, const octomap::OcTreeNode* from,
                      octomap::OcTreeNode* to) {
  to->setLogOdds(from->getLogOdds());
  for (unsigned i = 0; i < 8 && source.nodeHasChildren(from); ++i) {
    if (source.nodeChildExists(from, i)) {
      Copy(source, source.getNodeChild(from, i), createNodeChild(to, i));
    }
  }
}

// OctoMap frees a node's array of children only where it merges eight equal ones.
void ScanOctree::RemoveChildren(octomap::OcTreeNode* node) {
  for (unsigned i = 0; i < 8; ++i) {
    bool created = false;
    octomap::OcTreeNode* const child = Child(node, i, created);
    if (nodeHasChildren(child)) RemoveChildren(child);
    child->setLogOdds(0.0f);
  }
  pruneNode(node);
}

}  // namespace highwall::internal
