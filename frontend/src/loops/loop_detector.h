#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>

#include "features/depth_grid.h"
#include "loops/keyframe_graph.h"
#include "map/map_matcher.h"
#include "tracking/relocalizer.h"

namespace highwall {

// A loop that was seen and not believed.
struct RefusedLoop {
  LoopEdge edge;
  std::string reason;  // the test that refused it, with its figure
};

// Finds loops, a keyframe at a time. A candidate must look alike, points and lines voting; must not
// be connected with the keyframe by the map; must be named by several keyframes in a row (a place
// is a keyframe with those that share its landmarks); must give a pose by RANSAC, refined on points
// and lines, that explains the landmarks of the place by projection; and that pose must lie within
// the drift that the way between may have gathered. (The chain of checks is that of Mur-Artal,
// Montiel, Tardos, IEEE T-RO 2015, section VII; the gate is ours.)
//
// Between submaps that are not joined there is no drift to judge by: there several keyframes in a
// row must tell the same transform between them, or one beyond doubt.
class LoopDetector {
 public:
  // model: must outlive the detector. graph: the drift that is thought possible.
  explicit LoopDetector(const MeasurementModel& model, const LoopDetectorOptions& options = {},
                        const KeyFrameGraphOptions& graph = {});

  // To be called with every new keyframe. loops: found before.
  std::optional<Loop> Detect(const Map& map, KeyFrameId keyframe, std::span<const LoopEdge> loops);

  // Against one candidate (live), appearance and time aside.
  std::optional<Loop> Verify(const Map& map, KeyFrameId keyframe, KeyFrameId candidate,
                             std::span<const LoopEdge> loops);

  // What Detect() and Verify() have refused since the last call, after a pose was found.
  std::vector<RefusedLoop> TakeRefused() { return std::exchange(refused_, {}); }

  // The map was moved: what the last keyframes told of another submap's place holds no more.
  void Forget() { merge_candidate_.reset(); }

 private:
  // Keyframes that share landmarks, ascending, and how many queries in a row have named them.
  struct Place {
    std::vector<KeyFrameId> keyframes;
    int votes = 0;
  };
  // Where one submap is in the world of another, as keyframes in a row have told.
  struct MergeCandidate {
    SubmapId own = kNoId, other = kNoId;  // roots
    Pose T_other_own;
    int keyframes = 0;
  };
  struct Candidates {
    std::vector<KeyFrameId> loops;   // of the keyframe's world
    std::vector<KeyFrameId> merges;  // of others
  };
  // A keyframe as it was found in a place. share: LoopDetectorOptions::min_found.
  struct Found {
    Loop loop;
    int support = 0;
    double share = 0.0;
  };

  Candidates FindCandidates(const Map& map, KeyFrameId keyframe) const;
  std::optional<Loop> DetectLoop(const Map& map, KeyFrameId keyframe,
                                 std::span<const KeyFrameId> candidates,
                                 std::span<const LoopEdge> loops);
  std::optional<Loop> DetectMerge(const Map& map, KeyFrameId keyframe,
                                  std::span<const KeyFrameId> candidates);
  // Whether it tells of the transform that keyframes in a row have told; remembers it.
  bool Agrees(const Map& map, const LoopEdge& edge);
  // Whether gravity or the depth of the two submaps forbids that they are joined.
  bool Contradicts(const Map& map, const LoopEdge& edge);
  std::optional<Found> FindPlace(const Map& map, KeyFrameId keyframe, KeyFrameId candidate);
  Place PlaceOf(const Map& map, KeyFrameId keyframe) const;
  void Refuse(const LoopEdge& edge, std::string reason);

  const MeasurementModel& model_;
  LoopDetectorOptions options_;
  KeyFrameGraphOptions graph_;
  Relocalizer relocalizer_;
  MapMatcher matcher_;
  DepthGrid grid_;
  std::vector<Place> places_;  // that the last keyframe named
  std::optional<MergeCandidate> merge_candidate_;
  std::vector<RefusedLoop> refused_;
};

}  // namespace highwall
