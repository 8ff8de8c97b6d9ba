#pragma once

#include <cstddef>
#include <vector>

#include <highwall/mapping/octomap_builder.h>

namespace highwall::bench {

// Whether the leaves have the same place, size and log-odds to the last bit.
inline bool SameLeaves(const OctomapBuilder& a, const OctomapBuilder& b) {
  std::vector<OctreeLeaf> leaves;
  a.ForEachLeaf([&](const OctreeLeaf& leaf) { leaves.push_back(leaf); });
  std::size_t i = 0;
  bool same = true;
  b.ForEachLeaf([&](const OctreeLeaf& leaf) {
    same = same && i < leaves.size() && leaves[i].center_W == leaf.center_W &&
           leaves[i].size == leaf.size && leaves[i].log_odds == leaf.log_odds;
    ++i;
  });
  return same && i == leaves.size();
}

}  // namespace highwall::bench
