#pragma once

#include <vector>

#include <highwall/frontend/map/map.h>

namespace highwall {

// Adds keyframes and landmarks of another map next to those of this one: they get new ids, in their
// order, and its submaps remain separate or merged as they are, in worlds of their own. The motion
// estimated with an IMU is not copied. Returns the new ids of its keyframes, in their order.
std::vector<KeyFrameId> AddMap(const Map& other, Map* map);

}  // namespace highwall
