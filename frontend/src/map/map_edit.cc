#include "map/map_edit.h"

#include <algorithm>
#include <utility>

#include <highwall/core/error.h>

namespace highwall {
namespace {

template <class Value, class Tag, class Read>
std::unordered_map<Id<Tag>, Value> ById(const std::vector<Id<Tag>>& ids, const Read& read) {
  std::unordered_map<Id<Tag>, Value> values;
  values.reserve(ids.size());
  for (const Id<Tag> id : ids) values.emplace(id, read(id));
  return values;
}

// Returns nullptr if there is none.
template <class Tag, class Value>
const Value* At(const std::unordered_map<Id<Tag>, Value>& values, Id<Tag> id) {
  const auto found = values.find(id);
  return found != values.end() ? &found->second : nullptr;
}

// The moves D_W of all keyframes of the map: x_W <- D_W x_W.
class Moves {
 public:
  Moves(const MapEdit& edit, const Map& map) {
    std::unordered_map<SubmapId, Pose> newest;
    for (const KeyFrameId id : map.keyframe_ids()) {
      const KeyFrame& keyframe = *map.keyframe(id);
      Pose& D = newest[map.Root(keyframe.submap)];
      const Pose* after = At(edit.after.keyframes, id);
      if (after) D = *after * keyframe.T_WC.Inverse();
      moves_.emplace(id, D);
    }
  }

  const Pose& operator[](KeyFrameId id) const { return moves_.at(id); }
  // Returns the move of a landmark: that of the first keyframe that observes it.
  Pose Of(const std::vector<Observation>& observations) const {
    return observations.empty() ? Pose() : (*this)[observations.front().keyframe];
  }

 private:
  std::unordered_map<KeyFrameId, Pose> moves_;
};

// Returns the world of its keyframes; empty if none of them exists any longer.
std::optional<SubmapId> WorldOf(const MapGeometry& after, const Map& map) {
  for (const auto& [id, pose] : after.keyframes) {
    if (const std::optional<SubmapId> root = map.RootOf(id)) return root;
  }
  return std::nullopt;
}

}  // namespace

MapGeometry GeometryOf(const Map& map, SubmapId submap) {
  const std::vector<KeyFrameId> keyframes = map.KeyFramesOf(submap);
  MapGeometry geometry;
  geometry.keyframes = ById<Pose>(keyframes, [&](auto id) { return map.keyframe(id)->T_WC; });
  ForEachKind([&]<class Landmark>() {
    using Traits = LandmarkTraits<Landmark>;
    PartOf<Landmark>(geometry.landmarks) =
        ById<typename Traits::Geometry>(map.SeenBy<Landmark>(keyframes),
                                        [&](auto id) { return Traits::PositionOf(*map.Find(id)); });
  });
  geometry.frames = map.factors().PlacesIn(map.Root(submap));
  return geometry;
}

MapEdit AdjustedTo(const Map& map, OutlierObservations outliers, SubmapId submap) {
  MapEdit edit{.after = GeometryOf(map, submap),
               .fusion = {},
               .outliers = std::move(outliers),
               .gravity_W = map.gravity_W(submap)};
  for (const auto& [id, pose] : edit.after.keyframes) {
    if (const auto& motion = map.keyframe(id)->motion) {
      edit.motions.emplace(id, BodyMotion{motion->v_WB, motion->bias});
    }
  }
  return edit;
}

void Apply(const MapEdit& edit, Map* map) {
  const auto& [after, fusion, outliers, merge, motions, gravity_W] = edit;
  const Moves moves(edit, *map);
  ForEachKind([&]<class Landmark>() {
    using Traits = LandmarkTraits<Landmark>;
    for (const Id<Landmark> id : map->ids<Landmark>()) {
      Landmark& landmark = *map->Find(id);
      const Pose D = moves.Of(landmark.observations);
      const auto* const to = At(PartOf<Landmark>(edit.after.landmarks), id);
      auto& position = Traits::PositionOf(landmark);
      position = to ? *to : D * position;
      Traits::Rotate(D.R(), landmark);
    }
  });
  for (const KeyFrameId id : map->keyframe_ids()) {
    Pose& T_WC = map->keyframe(id)->T_WC;
    T_WC = moves[id] * T_WC;
    auto& motion = map->keyframe(id)->motion;
    if (!motion) continue;
    motion->v_WB = moves[id].q() * motion->v_WB;
    if (const BodyMotion* found = At(motions, id)) {
      motion->v_WB = found->v_WB;
      motion->bias = found->bias;
    }
  }
  if (merge) map->Join(merge->root, merge->other);
  if (const auto root = WorldOf(after, *map)) {
    for (const auto& [frame, T_FW] : after.frames) map->factors().Place(frame, *root, T_FW);
    if (gravity_W) map->SetGravity(gravity_W, *root);
  }
  Apply(fusion, map);
  Forget(outliers, map);
}

void MoveKeyFrames(const std::vector<KeyFrameId>& keyframes, const std::vector<Pose>& T_WC,
                   Map* map) {
  HIGHWALL_REQUIRE(keyframes.size() == T_WC.size(),
                   "MoveKeyFrames: there must be one pose for each keyframe");
  MapEdit edit;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    edit.after.keyframes.emplace(keyframes[i], T_WC[i]);
  }
  Apply(edit, map);
}

}  // namespace highwall
