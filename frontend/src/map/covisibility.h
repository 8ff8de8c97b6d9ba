#pragma once

#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/options.h>

namespace highwall {

// Returns the keyframes that share most landmarks with `centre`, at least min_shared, most first;
// at most `most` of them.
std::vector<KeyFrameId> Neighbours(const Map& map, KeyFrameId centre, int min_shared, int most);

// The same with `centre` itself in front.
std::vector<KeyFrameId> WithNeighbours(const Map& map, KeyFrameId centre, int min_shared, int most);

}  // namespace highwall
