#include "tracking/landmarks_around.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <utility>

namespace highwall {

LandmarksAround::LandmarksAround(const Map& map) : map_(map) {
  ForEachKind([&]<class Landmark>() {
    const std::vector<Id<Landmark>> ids = map.ids<Landmark>();
    if (ids.empty()) return;
    Counts<Landmark>& counts = PartOf<Landmark>(counts_);
    counts.first = ids.front();
    counts.observers.assign(ids.back().index() - ids.front().index() + 1, 0);
  });
}

void LandmarksAround::MoveTo(std::span<const KeyFrameId> keyframes) {
  std::vector<KeyFrameId> now(keyframes.begin(), keyframes.end()), come, gone;
  std::ranges::sort(now);
  std::ranges::set_difference(now, keyframes_, std::back_inserter(come));
  std::ranges::set_difference(keyframes_, now, std::back_inserter(gone));
  for (const KeyFrameId id : come) Count(id, 1);
  for (const KeyFrameId id : gone) Count(id, -1);
  keyframes_ = std::move(now);
}

template <LandmarkKind Landmark>
std::vector<Id<Landmark>> LandmarksAround::Except(std::span<const Id<Landmark>> except) {
  Counts<Landmark>& counts = PartOf<Landmark>(counts_);
  std::vector<std::pair<std::uint16_t*, std::uint16_t>> hidden;
  hidden.reserve(except.size());
  for (const Id<Landmark> id : except) {
    std::uint16_t* const count = Find(id);
    if (count != nullptr) hidden.emplace_back(count, std::exchange(*count, std::uint16_t{0}));
  }
  std::vector<Id<Landmark>> seen;
  const std::vector<std::uint16_t>& observers = counts.observers;
  // Most ids of a large map are not seen from here: they are skipped in blocks.
  constexpr std::size_t kBlock = 4;
  for (std::size_t begin = 0; begin < observers.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, observers.size());
    std::uint64_t any = 0;
    std::memcpy(&any, &observers[begin], (end - begin) * sizeof(std::uint16_t));
    if (any == 0) continue;
    for (std::size_t i = begin; i < end; ++i) {
      if (observers[i] != 0) seen.emplace_back(counts.first.index() + i);
    }
  }
  // Backwards, since a landmark may be listed twice.
  for (auto it = hidden.rbegin(); it != hidden.rend(); ++it) *it->first = it->second;
  return seen;
}

template <class Landmark>
std::uint16_t* LandmarksAround::Find(Id<Landmark> id) {
  Counts<Landmark>& counts = PartOf<Landmark>(counts_);
  if (id < counts.first) return nullptr;
  const std::size_t i = id.index() - counts.first.index();
  return i < counts.observers.size() ? &counts.observers[i] : nullptr;
}

void LandmarksAround::Count(KeyFrameId keyframe, int step) {
  ForEachKind([&]<class Landmark>() {
    for (const Id<Landmark> id : PartOf<Landmark>(*map_.keyframe(keyframe))) {
      std::uint16_t* const count = Find(id);
      if (count != nullptr) *count = static_cast<std::uint16_t>(*count + step);
    }
  });
}

template std::vector<PointId> LandmarksAround::Except<MapPoint>(std::span<const PointId>);
template std::vector<LineId> LandmarksAround::Except<MapLine>(std::span<const LineId>);

}  // namespace highwall
