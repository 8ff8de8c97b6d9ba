#pragma once

#include <algorithm>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <unordered_map>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

struct NoId {};
// Invalid id of any kind: below every valid id.
inline constexpr NoId kNoId;

// Identifier of a part of a Map. Ids of one kind ascend from 0 and are never reused; ids of two
// kinds do not convert to each other. Tag: the kind.
template <class Tag>
class Id {
 public:
  constexpr Id() = default;  // kNoId
  constexpr Id(NoId) {}
  template <std::integral Number>
  constexpr explicit Id(Number value) : value_(static_cast<std::int32_t>(value)) {}

  constexpr std::int32_t value() const { return value_; }
  // Index into an array with an entry for every id; beyond all of them for kNoId.
  constexpr std::size_t index() const { return static_cast<std::size_t>(value_); }

  constexpr Id& operator++() {
    ++value_;
    return *this;
  }
  friend constexpr auto operator<=>(Id, Id) = default;
  friend std::ostream& operator<<(std::ostream& stream, Id id) { return stream << id.value_; }

 private:
  std::int32_t value_ = -1;
};

struct MapPoint;  // highwall/frontend/map/landmark.h
struct MapLine;
// Identifiers of keyframes, points and lines. The tag of a landmark is its type, so a function
// template deduces the kind of landmark from its id.
using KeyFrameId = Id<struct KeyFrameTag>;
using PointId = Id<MapPoint>;
using LineId = Id<MapLine>;
// A sequence of keyframes connected by odometry (Map).
using SubmapId = Id<struct SubmapTag>;
// A frame outside of the map (ReferenceFrame).
using ReferenceFrameId = Id<struct ReferenceFrameTag>;

// The submap that every map has from the beginning.
inline constexpr SubmapId kFirstSubmap{0};

// Table of values by ids that ascend from 0 and are never reused. Memory grows with the values that
// exist, not with the ids that were issued; a value keeps its address until it is removed. T: has a
// member `id`, an Id.
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
  // Copies a value of another table, keeping its id.
  T& Put(const T& value) {
    if (!(value.id < end_)) end_ = KeyType(value.id.value() + 1);
    return values_[value.id] = value;
  }
  void Remove(KeyType id) { values_.erase(id); }

  // Returns nullptr where there is none or it was removed.
  T* Find(KeyType id) {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }
  const T* Find(KeyType id) const {
    const auto found = values_.find(id);
    return found != values_.end() ? &found->second : nullptr;
  }

  std::size_t size() const { return values_.size(); }
  // Returns an upper bound (exclusive) of the ids issued so far.
  KeyType end_id() const { return end_; }
  // Ids in use, ascending.
  std::vector<KeyType> ids() const {
    std::vector<KeyType> ids;
    ids.reserve(values_.size());
    for (const auto& [id, value] : values_) ids.push_back(id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  // Pairs of id and value, in no particular order.
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }

 private:
  std::unordered_map<KeyType, T> values_;
  KeyType end_{0};
};

}  // namespace highwall

template <class Tag>
struct std::hash<highwall::Id<Tag>> {
  std::size_t operator()(highwall::Id<Tag> id) const noexcept {
    return std::hash<std::int32_t>()(id.value());
  }
};
