#include "voxel_brick.h"

namespace highwall::internal {

std::array<int, 3> FirstVoxel(std::uint64_t morton) {
  std::array<int, 3> voxel{};
  for (unsigned bit = 0; bit < 39; ++bit) {
    voxel[bit % 3] |= static_cast<int>(morton >> bit & 1u) << (bit / 3 + 3);
  }
  return voxel;
}

void VoxelBrick::Finish() {
  for (std::size_t i = 0; i < 8; ++i) {
    far.words[i] &= ~occupied.words[i];
    free.words[i] &= ~(occupied.words[i] | far.words[i]);
    any_free |= free.words[i] != 0;
    any_occupied |= occupied.words[i] != 0;
    any_far |= far.words[i] != 0;
  }
}

void VoxelBrick::KeepFarHits() {
  occupied = far;
  free = far = {};
  any_occupied = any_far;
  any_free = any_far = false;
}

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
