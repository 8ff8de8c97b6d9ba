#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace highwall::internal {

// Assigns the numbers 0, 1, 2, ... to 64-bit keys in the order of their first appearance: the flat
// hash table (open addressing, linear probing) of the voxel filter and the scan.
class KeyIndex {
 public:
  KeyIndex();

  std::size_t size() const { return size_; }
  // Returns the number of `key`, assigned now if it is new. key: any except 2^64 - 1.
  std::uint32_t Insert(std::uint64_t key) {
    std::size_t slot = Home(key);
    while (slots_[slot].key != key) {
      if (slots_[slot].key == kEmpty) return Add(slot, key);
      slot = (slot + 1) & mask_;
    }
    return slots_[slot].index;
  }
  // Removes all keys and keeps the memory.
  void Clear();

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
  struct Slot {
    std::uint64_t key = kEmpty;
    std::uint32_t index = 0;
  };

  // Fibonacci hashing: the top bits of a product with 2^64 / golden ratio.
  std::size_t Home(std::uint64_t key) const {
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ull) >> shift_);
  }
  std::uint32_t Add(std::size_t slot, std::uint64_t key);
  void Grow();

  std::vector<Slot> slots_;
  std::size_t mask_;
  int shift_;
  std::size_t size_ = 0;
};

}  // namespace highwall::internal
