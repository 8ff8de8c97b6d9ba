#pragma once

#include <cstddef>
#include <string>

namespace [[gnu::visibility("default")]] highwall {

// What a part of a system holds in memory: its values, without what the allocator adds.
struct MemoryShare {
  std::string holder;
  std::size_t bytes = 0;
};

}  // namespace highwall
