#include "voxel_brick.h"

namespace highwall::internal {

void BrickTable::Clear() {
  for (const VoxelBrick& brick : bricks_) slots_[brick.morton % kSlots] = {};
  bricks_.clear();
  index_.Clear();
}

std::uint32_t BrickTable::Find(std::uint64_t morton) {
  const std::uint32_t index = index_.Insert(morton);
  if (index == bricks_.size()) bricks_.emplace_back().morton = morton;
  slots_[morton % kSlots] = {static_cast<std::uint32_t>(morton / kSlots), index};
  return index;
}

}  // namespace highwall::internal
