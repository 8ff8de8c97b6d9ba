#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/loops/keyframe_graph.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_matcher.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/relocalizer.h>

namespace highwall {

struct LoopDetectorOptions {
  int min_shared = 15;        // >= 1: landmarks that two keyframes of one place share
  int candidates = 3;         // >= 1: keyframes looked at, most alike first
  double min_score = 0.01;    // [0, 1]: of the index
  double score_share = 0.25;  // [0, 1]: of the score of the best neighbour in the map
  int consistency = 3;        // >= 1: keyframes in a row that name one place before it is verified
  RelocalizerOptions verification{.min_inliers = 20, .ransac_iterations = 300};
  MapMatcherOptions matcher{};   // for the search by projection
  int place_keyframes = 10;      // >= 0: neighbours of the candidate whose landmarks are searched
  int min_support = 50;          // >= 6: inlier points plus twice the lines, after that search
  double min_found = 0.25;       // [0, 1]: their share of the landmarks in view
  KeyFrameGraphOptions graph{};  // the drift that is thought possible

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A place seen again.
struct Loop {
  LoopEdge edge;
  std::vector<std::pair<int, PointId>> points;  // feature of edge.keyframe -> landmark of old
  std::vector<std::pair<int, LineId>> lines;
  double chi2 = 0.0;  // of the correction against the drift that is thought possible
};

// Finds loops, a keyframe at a time. A candidate must look alike, points and lines voting; must not
// be connected with the keyframe by the map; must be named by several keyframes in a row (a place
// is a keyframe with those that share its landmarks); must give a pose by RANSAC, refined on points
// and lines, that explains the landmarks of the place by projection; and that pose must lie within
// the drift that the way between may have gathered. (The chain of checks is that of Mur-Artal,
// Montiel, Tardos, IEEE T-RO 2015, section VII; the gate is ours.)
class LoopDetector {
 public:
  // levels: of the ORB pyramid. model: must outlive the detector.
  LoopDetector(const MeasurementModel& model, int levels, const LoopDetectorOptions& options = {});

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
  Relocalizer relocalizer_;
  MapMatcher matcher_;
  std::vector<Place> places_;  // that the last keyframe named
};

}  // namespace highwall
