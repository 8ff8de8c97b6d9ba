#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace highwall {

// Values under ids that ascend from 0 and are never used again. Memory follows the values that
// live, not the ids that were given; a value stays where it is until it is removed. T: has an `id`.
template <class T>
class IdTable {
 public:
  T& Add() {
    T& value = values_[next_];
    value.id = next_++;
    return value;
  }
  void Remove(std::int32_t id) { values_.erase(id); }

  // nullptr where there is none (any more).
  T* Find(std::int32_t id) {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }
  const T* Find(std::int32_t id) const {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }

  std::size_t size() const { return values_.size(); }
  // Above every id that was given.
  std::int32_t end_id() const { return next_; }
  // Live ids, ascending.
  std::vector<std::int32_t> ids() const {
    std::vector<std::int32_t> ids;
    ids.reserve(values_.size());
    for (const auto& [id, value] : values_) ids.push_back(id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  // Live pairs of id and value, in no order.
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }

 private:
  std::unordered_map<std::int32_t, T> values_;
  std::int32_t next_ = 0;
};

}  // namespace highwall
