#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/map/keyframe.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/map_ids.h>

namespace [[gnu::visibility("default")]] highwall {

// All landmarks of one kind in a map. It keeps two records of an observation equal: the list of the
// landmark, and the entry of the observing feature in the keyframe. Not thread-safe.
template <class Landmark>
class LandmarkTable {
 public:
  using Traits = LandmarkTraits<Landmark>;
  using LandmarkId = Id<Landmark>;

  // Adds a landmark that no keyframe observes yet. frame_index: of its creation.
  Landmark& Add(const typename Traits::Geometry& geometry, std::int64_t frame_index) {
    Landmark& landmark = landmarks_.Add();
    Traits::PositionOf(landmark) = geometry;
    landmark.first_frame = frame_index;
    return landmark;
  }
  // Copies those of another table that the keyframe observes, with their observations by
  // `keyframes`, under the same ids.
  void Put(const LandmarkTable& other, const KeyFrame& keyframe,
           const IdTable<KeyFrame>& keyframes) {
    for (const LandmarkId id : PartOf<Landmark>(keyframe)) {
      if (id == kNoId || Find(id) != nullptr) continue;
      std::erase_if(landmarks_.Put(*other.Find(id)).observations,
                    [&](const Observation& o) { return keyframes.Find(o.keyframe) == nullptr; });
    }
  }

  // Returns nullptr where there is none or it was removed.
  Landmark* Find(LandmarkId id) { return landmarks_.Find(id); }
  const Landmark* Find(LandmarkId id) const { return landmarks_.Find(id); }
  // Ids in use, ascending.
  std::vector<LandmarkId> ids() const { return landmarks_.ids(); }
  std::size_t size() const { return landmarks_.size(); }

  // Records an observation by feature `index` of the keyframe. Returns false and changes nothing if
  // there is no such landmark, if the keyframe observes it already or if the feature is assigned.
  bool Observe(KeyFrame* keyframe, int index, LandmarkId id) {
    Landmark* const landmark = Find(id);
    if (landmark == nullptr || SlotOf(keyframe, index) != kNoId) return false;
    auto& observations = landmark->observations;
    if (std::any_of(observations.begin(), observations.end(),
                    [&](const Observation& o) { return o.keyframe == keyframe->id; })) {
      return false;
    }
    SlotOf(keyframe, index) = id;
    const auto next = std::find_if(observations.begin(), observations.end(),
                                   [&](const Observation& o) { return o.keyframe > keyframe->id; });
    observations.insert(next, {keyframe->id, index});
    return true;
  }
  // Removes the observation by a keyframe, and the landmark if no observation remains.
  void Forget(KeyFrame* keyframe, LandmarkId id) {
    Landmark* const landmark = Find(id);
    if (landmark == nullptr) return;
    std::erase_if(landmark->observations, [&](const Observation& o) {
      if (o.keyframe != keyframe->id) return false;
      SlotOf(keyframe, o.index) = kNoId;
      return true;
    });
    if (landmark->observations.empty()) landmarks_.Remove(id);
  }
  // keyframes: those of the map, here and below.
  void Remove(LandmarkId id, IdTable<KeyFrame>* keyframes) {
    const Landmark* const landmark = Find(id);
    if (landmark == nullptr) return;
    for (const Observation& o : landmark->observations) {
      SlotOf(keyframes->Find(o.keyframe), o.index) = kNoId;
    }
    landmarks_.Remove(id);
  }
  // Moves every observation of `from` to `into`, unless its keyframe observes `into` already.
  void Merge(LandmarkId from, LandmarkId into, IdTable<KeyFrame>* keyframes) {
    const Landmark* const merged = Find(from);
    Landmark* const remaining = Find(into);
    if (from == into || merged == nullptr || remaining == nullptr) return;
    const std::vector<Observation> moved = merged->observations;
    remaining->visible += merged->visible;
    remaining->found += merged->found;
    Remove(from, keyframes);
    for (const Observation& o : moved) Observe(keyframes->Find(o.keyframe), o.index, into);
  }

  // Map::SeenBy, with the keyframes of the map. Ids are marked instead of sorted: each is seen by
  // many keyframes, and one byte per id between the first and the last is cheap up to millions.
  static std::vector<LandmarkId> SeenBy(const IdTable<KeyFrame>& all,
                                        std::span<const KeyFrameId> keyframes,
                                        std::span<const LandmarkId> except) {
    LandmarkId first = kNoId, end = kNoId;
    for (const KeyFrameId keyframe : keyframes) {
      for (const LandmarkId id : PartOf<Landmark>(*all.Find(keyframe))) {
        if (id == kNoId) continue;
        if (first == kNoId || id < first) first = id;
        if (!(id < end)) end = LandmarkId(id.value() + 1);
      }
    }
    std::vector<LandmarkId> seen;
    if (first == kNoId) return seen;
    std::vector<std::uint8_t> marked(end.index() - first.index(), 0);
    const auto mark = [&](LandmarkId id, std::uint8_t value) {
      if (!(id < first) && id < end) marked[id.index() - first.index()] = value;
    };
    for (const KeyFrameId keyframe : keyframes) {
      for (const LandmarkId id : PartOf<Landmark>(*all.Find(keyframe))) mark(id, 1);
    }
    for (const LandmarkId id : except) mark(id, 0);
    for (LandmarkId id = first; id < end; ++id) {
      if (marked[id.index() - first.index()] != 0) seen.push_back(id);
    }
    return seen;
  }

  // Calls f(landmark) for each, by ascending ids.
  template <class F>
  void ForEach(const F& f) {
    for (Landmark& landmark : landmarks_) f(landmark);
  }

 private:
  // The landmark that a feature observes.
  static LandmarkId& SlotOf(KeyFrame* keyframe, int index) {
    return PartOf<Landmark>(*keyframe)[static_cast<std::size_t>(index)];
  }

  IdTable<Landmark> landmarks_;
};

}  // namespace highwall
