#pragma once

#include <cstddef>

// What factors that wrap another factor, whose first block is a pose, have in common.
namespace highwall::internal {

inline constexpr int kPoseBlock = 0, kPoseSize = 7;
inline constexpr std::size_t kMostBlocks = 8;  // of a wrapper, its own included

}  // namespace highwall::internal
