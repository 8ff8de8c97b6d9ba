#pragma once

#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/options.h>

#include "map/map_matcher.h"

namespace highwall {

// Which landmarks turned out to be one, and what keyframes observe besides.
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

// What it means that features of the keyframe are these landmarks: one that observed another
// landmark merges that into this, one that observed none observes this.
MapFusion FusionOf(const KeyFrame& keyframe, const PointMatches& points, const LineMatches& lines);

// Merges and adds observations; what is no more is passed over.
void Apply(const MapFusion& fusion, Map* map);

struct FusionOptions {
  InlierBounds inliers{};  // of a point's reading, depth included
  // Of two points that are one, the one with more observations stays; else the one that is looked
  // for does.
  bool keep_more_observed = false;
  // Features that observe a line take part, and their line merges with the one that is found.
  bool merge_lines = true;
};

// Looks for landmarks among the features of a keyframe by projection, and makes one in the map what
// is one. Features that observe a point take part: two landmarks on one feature are one landmark.
// Returns what was done.
MapFusion FuseLandmarks(KeyFrameId keyframe, std::span<const PointId> points,
                        std::span<const LineId> lines, const MapMatcher& matcher,
                        const FusionOptions& options, Map* map);

}  // namespace highwall
