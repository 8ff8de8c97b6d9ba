#include "map/add_map.h"

#include <map>
#include <unordered_map>
#include <utility>

namespace highwall {
namespace {

// New ids by old id.
using Submaps = std::map<SubmapId, SubmapId>;
using KeyFrames = std::unordered_map<KeyFrameId, KeyFrameId>;

Submaps AddSubmaps(const Map& other, Map* map) {
  Submaps submaps;
  for (const KeyFrameId id : other.keyframe_ids()) submaps[other.keyframe(id)->submap] = kNoId;
  for (auto& [old, added] : submaps) {
    added = map->AddSubmap();
    // The first keyframe of a world is never removed, so the root is among them, and older.
    map->Join(submaps.at(other.Root(old)), added);
    if (other.Root(old) == old) map->SetGravity(other.gravity_W(old), added);
  }
  return submaps;
}

// Frames remain separate even if they are the same: each map has its own estimate of T_FW.
void AddFactors(const Map& other, const Submaps& submaps, const KeyFrames& keyframes, Map* map) {
  std::map<ReferenceFrameId, ReferenceFrameId> frames;
  for (const ReferenceFrameId id : other.factors().frames()) {
    const ReferenceFrameId added = map->factors().AddFrame(other.factors().frame(id));
    frames[id] = added;
    for (const SubmapId root : other.roots()) {
      if (const auto T_FW = other.factors().T_FW(id, root)) {
        map->factors().Place(added, submaps.at(root), *T_FW);
      }
    }
  }
  for (MapFactor factor : other.factors().all()) {
    for (AnchoredBodyPose& pose : factor.poses) pose.keyframe = keyframes.at(pose.keyframe);
    if (factor.frame != kNoId) factor.frame = frames.at(factor.frame);
    map->AddFactor(std::move(factor));
  }
}

template <class Landmark>
void AddLandmarks(const Map& other, const KeyFrames& keyframes, Map* map) {
  for (const Id<Landmark> old_id : other.ids<Landmark>()) {
    const Landmark& old = *other.Find(old_id);
    Landmark& added =
        map->Add<Landmark>(LandmarkTraits<Landmark>::PositionOf(old), old.first_frame);
    const Id<Landmark> id = added.id;
    added = old;
    added.id = id;
    added.observations.clear();
    // It refers to a keyframe by its old id.
    if constexpr (requires { added.patch; }) added.patch.reset();
    for (const Observation& o : old.observations) {
      map->Observe(keyframes.at(o.keyframe), o.index, id);
    }
  }
}

}  // namespace

std::vector<KeyFrameId> AddMap(const Map& other, Map* map) {
  const Submaps submaps = AddSubmaps(other, map);
  std::vector<KeyFrameId> added;
  KeyFrames keyframes;
  for (const KeyFrameId id : other.keyframe_ids()) {
    const KeyFrame& old = *other.keyframe(id);
    KeyFrame& keyframe = map->AddKeyFrame(old.frame, old.T_WC, submaps.at(old.submap));
    keyframe.depth_grid = old.depth_grid;
    keyframe.found = old.found;
    keyframes[id] = keyframe.id;
    added.push_back(keyframe.id);
  }
  ForEachKind([&]<class Landmark>() { AddLandmarks<Landmark>(other, keyframes, map); });
  AddFactors(other, submaps, keyframes, map);
  return added;
}

}  // namespace highwall
