#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <ostream>
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

// Identifier of a keyframe. Those of landmarks are next to their kinds (landmark.h).
using KeyFrameId = Id<struct KeyFrameTag>;
// A sequence of keyframes connected by odometry (Map).
using SubmapId = Id<struct SubmapTag>;
// A frame outside of the map (ReferenceFrame).
using ReferenceFrameId = Id<struct ReferenceFrameTag>;

// The submap that every map has from the beginning.
inline constexpr SubmapId kFirstSubmap{0};

// Table of values by ids that ascend from 0 and are never reused. A lookup is two steps in arrays.
// Memory grows with the values that exist, and hardly with the ids that were issued (an eighth of a
// byte for each); a value keeps its address until it is removed. T: has a member `id`, an Id.
template <class T>
class IdTable {
  static constexpr std::size_t kPageSize = 64;
  struct Page {
    std::array<std::unique_ptr<T>, kPageSize> values;
    std::size_t used = 0;
  };

 public:
  using KeyType = decltype(T::id);

  // Visits the values by ascending ids.
  template <class Value>
  class Iterator {
   public:
    Iterator(const IdTable& table, std::size_t index) : table_(table), index_(index) { Skip(); }
    Value& operator*() const {
      return *table_.pages_[index_ / kPageSize]->values[index_ % kPageSize];
    }
    Iterator& operator++() {
      ++index_;
      Skip();
      return *this;
    }
    bool operator==(const Iterator& other) const { return index_ == other.index_; }

   private:
    // Goes to the next value, unless there is one here.
    void Skip() {
      const std::size_t end = table_.end_.index();
      while (index_ < end) {
        const Page* const page = table_.pages_[index_ / kPageSize].get();
        if (page == nullptr) {
          index_ = std::min(end, (index_ / kPageSize + 1) * kPageSize);
        } else if (page->values[index_ % kPageSize] == nullptr) {
          ++index_;
        } else {
          return;
        }
      }
    }

    const IdTable& table_;
    std::size_t index_;
  };

  IdTable() = default;
  IdTable(IdTable&&) noexcept = default;
  IdTable& operator=(IdTable&&) noexcept = default;
  // Copies the values.
  IdTable(const IdTable& other) {
    pages_.reserve(other.pages_.size());
    for (const T& value : other) Put(value);
    Issue(other.end_);
  }
  IdTable& operator=(const IdTable& other) { return *this = IdTable(other); }
  ~IdTable() = default;

  T& Add() {
    const KeyType id = end_;
    T& value = *(Slot(id) = std::make_unique<T>());
    value.id = id;
    return value;
  }
  // Copies a value of another table, keeping its id.
  T& Put(const T& value) { return *(Slot(value.id) = std::make_unique<T>(value)); }
  void Remove(KeyType id) {
    if (Find(id) == nullptr) return;
    std::unique_ptr<Page>& page = pages_[id.index() / kPageSize];
    page->values[id.index() % kPageSize].reset();
    --size_;
    if (--page->used == 0) page.reset();
  }

  // Returns nullptr where there is none or it was removed.
  T* Find(KeyType id) {
    const std::size_t page = id.index() / kPageSize;
    if (page >= pages_.size() || pages_[page] == nullptr) return nullptr;
    return pages_[page]->values[id.index() % kPageSize].get();
  }
  const T* Find(KeyType id) const { return const_cast<IdTable*>(this)->Find(id); }

  std::size_t size() const { return size_; }
  // Returns an upper bound (exclusive) of the ids issued so far.
  KeyType end_id() const { return end_; }
  // Ids in use, ascending.
  std::vector<KeyType> ids() const {
    std::vector<KeyType> ids;
    ids.reserve(size_);
    for (const T& value : *this) ids.push_back(value.id);
    return ids;
  }

  Iterator<T> begin() { return {*this, 0}; }
  Iterator<T> end() { return {*this, end_.index()}; }
  Iterator<const T> begin() const { return {*this, 0}; }
  Iterator<const T> end() const { return {*this, end_.index()}; }

 private:
  // Makes `end` the end of the ids that were issued, unless more were.
  void Issue(KeyType end) {
    if (end_ < end) end_ = end;
    pages_.resize((end_.index() + kPageSize - 1) / kPageSize);
  }
  // Returns the place of a value, which counts as in use.
  std::unique_ptr<T>& Slot(KeyType id) {
    Issue(KeyType(id.value() + 1));
    std::unique_ptr<Page>& page = pages_[id.index() / kPageSize];
    if (page == nullptr) page = std::make_unique<Page>();
    std::unique_ptr<T>& slot = page->values[id.index() % kPageSize];
    if (slot == nullptr) {
      ++page->used;
      ++size_;
    }
    return slot;
  }

  std::vector<std::unique_ptr<Page>> pages_;  // null where it has no value
  std::size_t size_ = 0;
  KeyType end_{0};
};

}  // namespace highwall

template <class Tag>
struct std::hash<highwall::Id<Tag>> {
  std::size_t operator()(highwall::Id<Tag> id) const noexcept {
    return std::hash<std::int32_t>()(id.value());
  }
};
