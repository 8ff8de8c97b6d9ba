#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>

namespace highwall {

struct NoId {};
// Of whatever kind: below every id that is given.
inline constexpr NoId kNoId;

// What names a part of a Map. Ids of one kind ascend from 0 and are never used again; those of two
// kinds do not mix. Tag: the kind.
template <class Tag>
class Id {
 public:
  constexpr Id() = default;  // kNoId
  constexpr Id(NoId) {}
  template <std::integral Number>
  constexpr explicit Id(Number value) : value_(static_cast<std::int32_t>(value)) {}

  constexpr std::int32_t value() const { return value_; }
  // Place in an array that has one for every id; beyond all of them for kNoId.
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

using KeyFrameId = Id<struct KeyFrameTag>;
using PointId = Id<struct PointTag>;
using LineId = Id<struct LineTag>;
// A run of keyframes that odometry ties one to the next (Map).
using SubmapId = Id<struct SubmapTag>;

// Every map has it, from the beginning.
inline constexpr SubmapId kFirstSubmap{0};

}  // namespace highwall

template <class Tag>
struct std::hash<highwall::Id<Tag>> {
  std::size_t operator()(highwall::Id<Tag> id) const noexcept {
    return std::hash<std::int32_t>()(id.value());
  }
};
