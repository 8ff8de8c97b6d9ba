#include "map/landmark_fusion.h"

#include <algorithm>

namespace highwall {
namespace {

template <class LandmarkId>
void Add(KeyFrameId keyframe, const std::vector<std::pair<int, LandmarkId>>& matches,
         const std::vector<LandmarkId>& observed,
         std::vector<std::pair<LandmarkId, LandmarkId>>* merged,
         std::vector<MapFusion::Found<LandmarkId>>* observations) {
  for (const auto& [feature, landmark] : matches) {
    const LandmarkId own = observed[static_cast<std::size_t>(feature)];
    if (own == kNoId) {
      observations->push_back({keyframe, feature, landmark});
    } else if (own != landmark) {
      merged->emplace_back(own, landmark);
    }
  }
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
  append(more.points, points);
  append(more.lines, lines);
  append(more.point_observations, point_observations);
  append(more.line_observations, line_observations);
}

MapFusion FusionOf(const KeyFrame& keyframe, const PointMatches& points, const LineMatches& lines) {
  MapFusion fusion;
  Add(keyframe.id, points, keyframe.points, &fusion.points, &fusion.point_observations);
  Add(keyframe.id, lines, keyframe.lines, &fusion.lines, &fusion.line_observations);
  return fusion;
}

void Apply(const MapFusion& fusion, Map* map) {
  for (const auto& [from, into] : fusion.points) map->Merge(from, into);
  for (const auto& [from, into] : fusion.lines) map->Merge(from, into);
  for (const auto& found : fusion.point_observations) {
    map->Observe(found.keyframe, found.feature, found.landmark);
  }
  for (const auto& found : fusion.line_observations) {
    map->Observe(found.keyframe, found.feature, found.landmark);
  }
}

MapFusion FuseLandmarks(KeyFrameId id, std::span<const PointId> points,
                        std::span<const LineId> lines, const MapMatcher& matcher,
                        const FusionOptions& options, Map* map) {
  const KeyFrame& keyframe = *map->keyframe(id);
  const FrameFeatures& features = *keyframe.frame.features;
  const std::vector<bool> points_taken(features.points.size(), false);
  PointMatches found = matcher.MatchPoints(features, keyframe.T_WC, *map, points, points_taken);
  std::erase_if(found, [&](const auto& match) {
    const PointFeature& feature = features.points[static_cast<std::size_t>(match.first)];
    return !(matcher.model().Chi2(feature, keyframe.T_WC, map->Find(match.second)->p_W) <=
             options.inliers.Of(MeasurementModel::Dimension(feature)));
  });
  std::vector<bool> lines_taken(features.lines.size(), false);
  if (!options.merge_lines) {
    std::transform(keyframe.lines.begin(), keyframe.lines.end(), lines_taken.begin(),
                   [](LineId line) { return line != kNoId; });
  }
  MapFusion fusion = FusionOf(
      keyframe, found, matcher.MatchLines(features, keyframe.T_WC, *map, lines, lines_taken));
  if (options.keep_more_observed) KeepMoreObserved(*map, &fusion.points);
  Apply(fusion, map);
  return fusion;
}

}  // namespace highwall
