#pragma once

#include <array>
#include <cstdint>

#include "voxel_brick.h"

namespace highwall::internal {

// Rays that are traversed side by side, one a lane of a vector.
constexpr int kRayLanes = 4;
// Vectors as g++ and clang have them: operators work lane by lane, comparisons give masks.
using RealLanes = double __attribute__((vector_size(8 * kRayLanes)));
using BitLanes = std::int64_t __attribute__((vector_size(8 * kRayLanes)));

// Rays ready for the traversal of Amanatides and Woo ("A fast voxel traversal algorithm for ray
// tracing", Eurographics 1987). Along axis i: the next border at distance next[i] [m], one more
// every delta[i]; the voxel as its bits of the Morton index, and what a step adds to them.
struct RayBatch {
  std::array<RealLanes, 3> next, delta;
  std::array<BitLanes, 3> voxel, step;
  BitLanes end;      // Morton index of the voxel to stop at
  RealLanes length;  // [m] rounding can lead past the end voxel: stop here
};

// Sets the free bits of the voxels of all rays up to, not including, the end.
void TraverseRays(const RayBatch& rays, BrickTable& bricks);

}  // namespace highwall::internal
