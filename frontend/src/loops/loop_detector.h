#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/loops/loop_report.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "loops/keyframe_graph.h"
#include "map/map_matcher.h"
#include "tracking/relocalizer.h"

namespace highwall {

// Finds loops, a keyframe at a time. A candidate must look alike, points and lines voting; must not
// be connected with the keyframe by the map; must be named by several keyframes in a row (a place
// is a keyframe with those that share its landmarks); must give a pose by RANSAC, refined on points
// and lines, that explains the landmarks of the place by projection; and that pose must lie within
// the drift that the way between may have gathered. (The chain of checks is that of Mur-Artal,
// Montiel, Tardos, IEEE T-RO 2015, section VII; the gate is ours.)
class LoopDetector {
 public:
  // model: must outlive the detector. graph: the drift that is thought possible.
  explicit LoopDetector(const MeasurementModel& model, const LoopDetectorOptions& options = {},
                        const KeyFrameGraphOptions& graph = {});

  // To be called with every new keyframe. loops: found before.
  std::optional<Loop> Detect(const Map& map, KeyFrameId keyframe, std::span<const LoopEdge> loops);

  // Against one candidate (live), appearance and time aside.
  std::optional<Loop> Verify(const Map& map, KeyFrameId keyframe, KeyFrameId candidate,
                             std::span<const LoopEdge> loops) const;

 private:
  // Keyframes that share landmarks, ascending, and how many queries in a row have named them.
  struct Place {
    std::vector<KeyFrameId> keyframes;
    int votes = 0;
  };
  std::vector<KeyFrameId> Candidates(const Map& map, KeyFrameId keyframe) const;
  Place PlaceOf(const Map& map, KeyFrameId keyframe) const;

  const MeasurementModel& model_;
  LoopDetectorOptions options_;
  KeyFrameGraphOptions graph_;
  Relocalizer relocalizer_;
  MapMatcher matcher_;
  std::vector<Place> places_;  // that the last keyframe named
};

}  // namespace highwall
