#pragma once

#include <vector>

#include <highwall/core/memory_share.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Returns what the parts of a map hold.
std::vector<MemoryShare> MemoryOf(const Map& map);

}  // namespace highwall
