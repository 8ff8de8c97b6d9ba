#include "view/scene_blocks.h"

#include <utility>

namespace highwall::apps {

void SceneBlocks::Set(const std::string& key, std::string data) {
  Block& block = blocks_[key];
  by_revision_.erase(block.revision);
  block = {++revision_, std::make_shared<const std::string>(std::move(data))};
  by_revision_.emplace(block.revision, block.data);
}

void SceneBlocks::Remove(const std::string& prefix) {
  auto block = blocks_.lower_bound(prefix);
  while (block != blocks_.end() && block->first.starts_with(prefix)) {
    by_revision_.erase(block->second.revision);
    block = blocks_.erase(block);
  }
}

std::vector<SceneBlocks::Text> SceneBlocks::After(std::uint64_t* known, std::size_t limit) const {
  std::vector<Text> found;
  std::size_t bytes = 0;
  for (auto at = by_revision_.upper_bound(*known); at != by_revision_.end(); ++at) {
    if (!found.empty() && bytes + at->second->size() > limit) break;
    bytes += at->second->size();
    found.push_back(at->second);
    *known = at->first;
  }
  return found;
}

bool SceneBlocks::HasAfter(std::uint64_t known) const {
  return by_revision_.upper_bound(known) != by_revision_.end();
}

}  // namespace highwall::apps
