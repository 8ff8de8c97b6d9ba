#pragma once

#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/options.h>

#include "map/map_matcher.h"

namespace highwall {

// Landmarks recognized as identical, and new observations.
struct MapFusion {
  template <class LandmarkId>
  struct Found {
    KeyFrameId keyframe;
    int feature = 0;
    LandmarkId landmark;
  };
  std::vector<std::pair<PointId, PointId>> points;  // (from, into)
  std::vector<std::pair<LineId, LineId>> lines;
  std::vector<Found<PointId>> point_observations;
  std::vector<Found<LineId>> line_observations;

  void Append(const MapFusion& more);
};

// Returns the fusion implied by matches of features of the keyframe: a feature that observed
// another landmark merges that into the matched one, one that observed none observes the matched
// one.
MapFusion FusionOf(const KeyFrame& keyframe, const PointMatches& points, const LineMatches& lines);

// Merges landmarks and adds observations; skips those that no longer exist.
void Apply(const MapFusion& fusion, Map* map);

struct FusionOptions {
  InlierBounds inliers{};  // of a point's observation, including depth
  // Of two identical points, keep the one with more observations; otherwise the one that was
  // searched.
  bool keep_more_observed = false;
  // Features that observe a line are included, and their line is merged with the matched one.
  bool merge_lines = true;
};

// Searches landmarks among the features of a keyframe by projection and merges identical ones in
// the map. Features that observe a point are included: two landmarks on one feature are identical.
// Returns the applied fusion.
MapFusion FuseLandmarks(KeyFrameId keyframe, std::span<const PointId> points,
                        std::span<const LineId> lines, const MapMatcher& matcher,
                        const FusionOptions& options, Map* map);

}  // namespace highwall
