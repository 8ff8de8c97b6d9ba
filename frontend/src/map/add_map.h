#pragma once

#include <vector>

#include <highwall/frontend/map/map.h>

namespace highwall {

// Puts keyframes and landmarks of another map beside those of this one: ids are given anew, in
// their order, and its submaps remain apart or joined as they are, in worlds of their own. The
// motion that an IMU told is left behind. Returns the new ids of its keyframes, in their order.
std::vector<KeyFrameId> AddMap(const Map& other, Map* map);

}  // namespace highwall
