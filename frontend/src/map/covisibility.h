#pragma once

#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/options.h>

namespace highwall {

// The keyframes that share most landmarks with `centre`, at least min_shared, most first: `most` of
// them at most.
std::vector<KeyFrameId> Neighbours(const Map& map, KeyFrameId centre, int min_shared, int most);

// The same behind `centre` itself.
std::vector<KeyFrameId> WithNeighbours(const Map& map, KeyFrameId centre, int min_shared, int most);

}  // namespace highwall
