#pragma once

#include <array>
#include <cstdint>

#include "voxel_brick.h"

namespace highwall::internal {

// Number of rays that are traversed in parallel, one per lane of a vector.
constexpr int kRayLanes = 4;
// Vector extensions of g++ and clang: operators work lane by lane, comparisons give masks.
using RealLanes = double __attribute__((vector_size(8 * kRayLanes)));
using BitLanes = std::int64_t __attribute__((vector_size(8 * kRayLanes)));

// Rays prepared for the traversal of Amanatides and Woo ("A fast voxel traversal algorithm for ray
// tracing", Eurographics 1987). Along axis i: the next border is at distance next[i] [m], further
// ones follow every delta[i]; the voxel is given by its bits of the Morton index, `step` is added
// to them in each step.
struct RayBatch {
  std::array<RealLanes, 3> next, delta;
  std::array<BitLanes, 3> voxel, step;
  BitLanes end;      // Morton index of the voxel to stop at
  RealLanes length;  // [m] rounding can lead past the end voxel: stop here
};

// Sets the free bits of the voxels of all rays up to, but not including, the end.
void TraverseRays(const RayBatch& rays, BrickTable& bricks);

}  // namespace highwall::internal
