#pragma once

#include <highwall/frontend/map/map_ids.h>

namespace highwall::testing {

// 3_kf is the fourth keyframe of a map.
constexpr KeyFrameId operator""_kf(unsigned long long value) {
  return KeyFrameId(value);
}

}  // namespace highwall::testing
