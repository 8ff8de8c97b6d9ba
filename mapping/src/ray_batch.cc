#include "ray_batch.h"

#include <highwall/internal/target_clones.h>

namespace highwall::internal {

// Two clones for different vector widths; AVX2 without FMA, so that both round identically.
HIGHWALL_TARGET_CLONES("avx2", "default")
void TraverseRays(const RayBatch& rays, BrickTable& bricks) {
  auto [next_x, next_y, next_z] = rays.next;
  auto [x, y, z] = rays.voxel;
  const BitLanes mask_x = BitLanes{} + static_cast<std::int64_t>(kMortonMaskX);
  const BitLanes mask_y = mask_x << 1, mask_z = mask_x << 2;
  BitLanes active = ~BitLanes{};
  do {
    const BitLanes at = x | y | z;
    // A ray that has reached its end writes its last voxel again.
    for (int lane = 0; lane < kRayLanes; ++lane) {
      const auto voxel = static_cast<std::uint64_t>(at[lane]);
      bricks.BrickOf(voxel).free.Set(voxel);
    }
    const BitLanes x_before_y = next_x < next_y;
    const RealLanes next_xy = x_before_y ? next_x : next_y;
    const BitLanes not_z = next_xy < next_z;
    const BitLanes go_x = x_before_y & not_z & active;
    const BitLanes go_y = ~x_before_y & not_z & active;
    const BitLanes go_z = ~not_z & active;
    next_x = go_x ? next_x + rays.delta[0] : next_x;
    next_y = go_y ? next_y + rays.delta[1] : next_y;
    next_z = go_z ? next_z + rays.delta[2] : next_z;
    // Ones in the gaps propagate the carry of the sum across them.
    const BitLanes new_x = ((x | ~mask_x) + (rays.step[0] & go_x)) & mask_x;
    const BitLanes new_y = ((y | ~mask_y) + (rays.step[1] & go_y)) & mask_y;
    const BitLanes new_z = ((z | ~mask_z) + (rays.step[2] & go_z)) & mask_z;
    const RealLanes nearest_xy = next_x < next_y ? next_x : next_y;
    const RealLanes nearest = nearest_xy < next_z ? nearest_xy : next_z;
    active &= ((new_x | new_y | new_z) != rays.end) & (nearest <= rays.length);
    x = active ? new_x : x;
    y = active ? new_y : y;
    z = active ? new_z : z;
  } while ((active[0] | active[1] | active[2] | active[3]) != 0);
}

}  // namespace highwall::internal
