#pragma once

#include <cstdint>

namespace highwall {

// What names the parts of a Map: they ascend and are never used again.
using KeyFrameId = std::int32_t;
using PointId = std::int32_t;
using LineId = std::int32_t;
// A run of keyframes that odometry ties one to the next (Map).
using SubmapId = std::int32_t;
inline constexpr std::int32_t kNoId = -1;

}  // namespace highwall
