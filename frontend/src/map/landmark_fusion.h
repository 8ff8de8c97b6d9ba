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
  template <class Landmark>
  struct NewObservation {
    KeyFrameId keyframe;
    int feature = 0;
    Id<Landmark> landmark;
  };
  template <class Landmark>
  using Merges = std::vector<std::pair<Id<Landmark>, Id<Landmark>>>;  // (from, into)
  template <class Landmark>
  using NewObservations = std::vector<NewObservation<Landmark>>;

  PerKind<Merges> merged;
  PerKind<NewObservations> observed;

  void Append(const MapFusion& more);
};

// Returns the fusion implied by matches of features of the keyframe: a feature that observed
// another landmark merges that into the matched one, one that observed none observes the matched
// one.
MapFusion FusionOf(const KeyFrame& keyframe, const PerKind<LandmarkMatches>& matches);

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

// Searches the landmarks of other keyframes, without those that the keyframe observes, among its
// features by projection and merges identical ones in the map. Features that observe a point are
// included: two landmarks on one feature are identical. Returns the applied fusion.
MapFusion FuseLandmarks(KeyFrameId keyframe, std::span<const KeyFrameId> others,
                        const MapMatcher& matcher, const FusionOptions& options, Map* map);

}  // namespace highwall
