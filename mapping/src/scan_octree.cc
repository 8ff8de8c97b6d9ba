#include "scan_octree.h"

#include <algorithm>
#include <utility>

namespace highwall::internal {
namespace {
constexpr unsigned kBrickDepth = 13;  // of 16: a brick has three levels
// Enough subtrees that the last worker finishes only slightly later than the others.
constexpr std::size_t kSubtreesPerWorker = 16;
}  // namespace

void ScanOctree::Apply(std::span<VoxelBrick* const> bricks, std::span<ScanOctree> helpers,
                       WorkerTeam& team) {
  if (bricks.empty()) return;
  const bool created = root == nullptr;
  if (created) {
    root = new octomap::OcTreeNode();  // owned, and deleted, by the base class
    ++tree_size;
  }
  size_changed = true;
  const Subtree whole{root, created, 0, bricks};
  if (helpers.empty()) return ApplyBricks(whole);

  std::vector<Subtree> subtrees;
  std::vector<octomap::OcTreeNode*> opened;
  Split(whole, bricks.size() / (kSubtreesPerWorker * (helpers.size() + 1)), subtrees, opened);
  for (ScanOctree& helper : helpers) {
    helper.prob_hit_log = prob_hit_log;
    helper.prob_miss_log = prob_miss_log;
    helper.clamping_thres_min = clamping_thres_min;
    helper.clamping_thres_max = clamping_thres_max;
  }
  team.Run(subtrees.size(), [&](std::size_t worker, std::size_t task) {
    (worker == 0 ? *this : helpers[worker - 1]).ApplyBricks(subtrees[task]);
  });
  // A helper that merged more nodes than it created has a negative count, which wraps around.
  for (ScanOctree& helper : helpers) tree_size += std::exchange(helper.tree_size, 0);
  for (octomap::OcTreeNode* const node : opened) Close(node);
}

void ScanOctree::ApplyBricks(const Subtree& subtree) {
  if (subtree.depth == kBrickDepth) {
    return ApplyBrick(subtree.node, subtree.created, *subtree.bricks.front());
  }
  if (VisitChildren(subtree, [this](const Subtree& child) { ApplyBricks(child); })) {
    Close(subtree.node);
  }
}

void ScanOctree::Split(const Subtree& subtree, std::size_t limit, std::vector<Subtree>& subtrees,
                       std::vector<octomap::OcTreeNode*>& opened) {
  if (subtree.depth == kBrickDepth || subtree.bricks.size() <= limit) {
    subtrees.push_back(subtree);
    return;
  }
  const auto split = [&](const Subtree& child) { Split(child, limit, subtrees, opened); };
  if (VisitChildren(subtree, split)) opened.push_back(subtree.node);
}

template <typename Visit>
bool ScanOctree::VisitChildren(const Subtree& subtree, const Visit& visit) {
  const auto& [node, created, depth, all_bricks] = subtree;
  std::span<VoxelBrick* const> bricks = all_bricks;
  if (!created && !nodeHasChildren(node)) {
    const bool any_free = std::ranges::any_of(bricks, [](auto* brick) { return brick->any_free; });
    const bool any_occupied =
        std::ranges::any_of(bricks, [](auto* brick) { return brick->any_occupied; });
    if (IsSaturated(node, any_free, any_occupied)) return false;
    expandNode(node);
  }
  const unsigned shift = 3 * (kBrickDepth - 1 - depth);
  while (!bricks.empty()) {
    const std::uint64_t prefix = bricks.front()->morton >> shift;
    const auto end = std::ranges::find_if(
        bricks, [&](const VoxelBrick* brick) { return brick->morton >> shift != prefix; });
    const auto count = static_cast<std::size_t>(end - bricks.begin());
    Subtree child{.depth = depth + 1, .bricks = bricks.first(count)};
    child.node = Child(node, static_cast<unsigned>(prefix & 7u), child.created);
    visit(child);
    bricks = bricks.subspan(count);
  }
  return true;
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

// OctoMap frees a node's array of children only if it merges eight equal ones.
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
