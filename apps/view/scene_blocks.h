#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace highwall::apps {

// The lasting content of the picture in blocks: the cloud of a keyframe, some keyframes, a cube of
// the octree. A block that changes gets a new revision, so that a client which knows everything up
// to a revision needs the blocks of later ones alone, each in its present state, however slow the
// client is. Not thread-safe.
class SceneBlocks {
 public:
  using Text = std::shared_ptr<const std::string>;

  // Sets the data of a block.
  void Set(const std::string& key, std::string data);
  // Removes the blocks whose keys begin with `prefix`. Clients are not informed.
  void Remove(const std::string& prefix);

  // Revision of the last change; 0: none yet.
  std::uint64_t revision() const { return revision_; }
  // Returns the blocks after revision *known in the order of their changes, at least one and then
  // as many as `limit` bytes hold, and advances *known to the last of them.
  std::vector<Text> After(std::uint64_t* known, std::size_t limit) const;
  bool HasAfter(std::uint64_t known) const;
  std::size_t size() const { return blocks_.size(); }

 private:
  struct Block {
    std::uint64_t revision = 0;
    Text data;
  };

  std::uint64_t revision_ = 0;
  std::map<std::string, Block> blocks_;
  std::map<std::uint64_t, Text> by_revision_;
};

}  // namespace highwall::apps
