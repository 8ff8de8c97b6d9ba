#pragma once

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <vector>

namespace highwall {

// Values under ids that ascend from 0 and are never used again. Memory follows the values that
// live, not the ids that were given; a value stays where it is until it is removed. T: has an
// `id`, an Id.
template <class T>
class IdTable {
 public:
  using KeyType = decltype(T::id);

  T& Add() {
    T& value = values_[end_];
    value.id = end_;
    ++end_;
    return value;
  }
  void Remove(KeyType id) { values_.erase(id); }

  // nullptr where there is none (any more).
  T* Find(KeyType id) {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }
  const T* Find(KeyType id) const {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }

  std::size_t size() const { return values_.size(); }
  // Above every id that was given.
  KeyType end_id() const { return end_; }
  // Live ids, ascending.
  std::vector<KeyType> ids() const {
    std::vector<KeyType> ids;
    ids.reserve(values_.size());
    for (const auto& [id, value] : values_) ids.push_back(id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  // Live pairs of id and value, in no order.
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }

 private:
  std::unordered_map<KeyType, T> values_;
  KeyType end_{0};
};

}  // namespace highwall
