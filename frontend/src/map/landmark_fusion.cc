#include "map/landmark_fusion.h"

#include <algorithm>
#include <type_traits>

namespace highwall {
namespace {

// Whether the projection of a matched landmark fits its feature. One that the matcher accepts does,
// unless it is a point.
template <class Feature, class Landmark>
bool IsInlier(const MeasurementModel&, const Feature&, const Pose&, const Landmark&,
              const InlierBounds&) {
  return true;
}
bool IsInlier(const MeasurementModel& model, const PointFeature& feature, const Pose& T_WC,
              const MapPoint& point, const InlierBounds& bounds) {
  return model.Chi2(feature, T_WC, point.p_W) <= bounds.Of(MeasurementModel::Dimension(feature));
}

// Matches landmarks of other keyframes with the features of a keyframe.
template <class Landmark>
LandmarkMatches<Landmark> MatchOthers(const KeyFrame& keyframe, std::span<const KeyFrameId> others,
                                      const MapMatcher& matcher, const FusionOptions& options,
                                      const Map& map) {
  const FrameFeatures& features = *keyframe.frame.features;
  const LandmarkIds<Landmark>& observed = PartOf<Landmark>(keyframe);
  std::vector<bool> taken(PartOf<Landmark>(features).size(), false);
  if (std::is_same_v<Landmark, MapLine> && !options.merge_lines) {
    std::transform(observed.begin(), observed.end(), taken.begin(),
                   [](Id<Landmark> id) { return id != kNoId; });
  }
  auto matches =
      matcher.Match(features, keyframe.T_WC, map, map.SeenBy<Landmark>(others, observed), taken);
  std::erase_if(matches, [&](const auto& match) {
    return !IsInlier(matcher.model(),
                     PartOf<Landmark>(features)[static_cast<std::size_t>(match.first)],
                     keyframe.T_WC, *map.Find(match.second), options.inliers);
  });
  return matches;
}

// Swaps the pairs whose first landmark has at least as many observations as the second.
void KeepMoreObserved(const Map& map, std::vector<std::pair<PointId, PointId>>* merged) {
  for (auto& [from, into] : *merged) {
    if (map.Find(from)->observations.size() >= map.Find(into)->observations.size()) {
      std::swap(from, into);
    }
  }
}

}  // namespace

void MapFusion::Append(const MapFusion& more) {
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  ForEachKind([&]<class Landmark>() {
    append(PartOf<Landmark>(more.merged), PartOf<Landmark>(merged));
    append(PartOf<Landmark>(more.observed), PartOf<Landmark>(observed));
  });
}

MapFusion FusionOf(const KeyFrame& keyframe, const PerKind<LandmarkMatches>& matches) {
  MapFusion fusion;
  ForEachKind([&]<class Landmark>() {
    for (const auto& [feature, landmark] : PartOf<Landmark>(matches)) {
      const Id<Landmark> own = PartOf<Landmark>(keyframe)[static_cast<std::size_t>(feature)];
      if (own == kNoId) {
        PartOf<Landmark>(fusion.observed).push_back({keyframe.id, feature, landmark});
      } else if (own != landmark) {
        PartOf<Landmark>(fusion.merged).emplace_back(own, landmark);
      }
    }
  });
  return fusion;
}

void Apply(const MapFusion& fusion, Map* map) {
  ForEachKind([&]<class Landmark>() {
    for (const auto& [from, into] : PartOf<Landmark>(fusion.merged)) map->Merge(from, into);
    for (const auto& found : PartOf<Landmark>(fusion.observed)) {
      map->Observe(found.keyframe, found.feature, found.landmark);
    }
  });
}

MapFusion FuseLandmarks(KeyFrameId id, std::span<const KeyFrameId> others,
                        const MapMatcher& matcher, const FusionOptions& options, Map* map) {
  const KeyFrame& keyframe = *map->keyframe(id);
  PerKind<LandmarkMatches> found;
  ForEachKind([&]<class Landmark>() {
    PartOf<Landmark>(found) = MatchOthers<Landmark>(keyframe, others, matcher, options, *map);
  });
  MapFusion fusion = FusionOf(keyframe, found);
  if (options.keep_more_observed) KeepMoreObserved(*map, &fusion.merged.points);
  Apply(fusion, map);
  return fusion;
}

}  // namespace highwall
