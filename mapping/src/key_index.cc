#include "key_index.h"

#include <algorithm>
#include <utility>

namespace highwall::internal {
namespace {
constexpr int kInitialBits = 10;
}

KeyIndex::KeyIndex()
    : slots_(std::size_t{1} << kInitialBits), mask_(slots_.size() - 1), shift_(64 - kInitialBits) {}

void KeyIndex::Clear() {
  std::fill(slots_.begin(), slots_.end(), Slot{});
  size_ = 0;
}

std::uint32_t KeyIndex::Add(std::size_t slot, std::uint64_t key) {
  const auto index = static_cast<std::uint32_t>(size_++);
  slots_[slot] = {key, index};
  if (2 * size_ > slots_.size()) Grow();
  return index;
}

void KeyIndex::Grow() {
  std::vector<Slot> old(2 * slots_.size());
  std::swap(old, slots_);
  mask_ = slots_.size() - 1;
  --shift_;
  for (const Slot& entry : old) {
    if (entry.key == kEmpty) continue;
    std::size_t slot = Home(entry.key);
    while (slots_[slot].key != kEmpty) slot = (slot + 1) & mask_;
    slots_[slot] = entry;
  }
}

}  // namespace highwall::internal
