#pragma once

#include <cstddef>

// Common definitions of factors that wrap another factor whose first block is a pose.
namespace highwall::internal {

inline constexpr int kPoseBlock = 0, kPoseSize = 7;
inline constexpr std::size_t kMostBlocks = 8;  // of a wrapper, including its own

}  // namespace highwall::internal
