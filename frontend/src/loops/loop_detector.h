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

// A loop that was detected but rejected.
struct RefusedLoop {
  LoopEdge edge;
  std::string reason;  // the test that rejected it, with its value
};

// Detects loops, one keyframe at a time. A candidate must be similar, by votes of points and lines;
// must not be connected with the keyframe in the map; must be found by several keyframes in a row
// (a place is a keyframe with those that share its landmarks), or by one of the last; must give a
// pose by RANSAC, refined on points and lines, that explains the landmarks of the place by
// projection; and that pose must be within the possible drift along the path between them. (The
// chain of checks is that of Mur-Artal, Montiel, Tardos, IEEE T-RO 2015, section VII; the gate is
// ours.)
//
// Between unconnected submaps there is no drift to test against: several keyframes in a row must
// give the same transform between them, or one with decisive support.
class LoopDetector {
 public:
  // model: must outlive the detector. graph: the model of possible drift.
  explicit LoopDetector(const MeasurementModel& model, const LoopDetectorOptions& options = {},
                        const KeyFrameGraphOptions& graph = {});

  // To be called with every new keyframe. loops: those found before.
  std::optional<Loop> Detect(const Map& map, KeyFrameId keyframe, std::span<const LoopEdge> loops);

  // To be called where no keyframes follow, since a recording often ends where it began. newest:
  // the last keyframes, active, of one world. Of the loops that they find, though too few in a row
  // may propose them, it returns the one with the most support, whose match ratio must be that of a
  // merge. Between submaps two of them must agree that match as much as in their own surroundings.
  std::optional<Loop> DetectLast(const Map& map, std::span<const KeyFrameId> newest,
                                 std::span<const LoopEdge> loops);

  // Verifies one candidate (active), without the tests of appearance and consistency.
  std::optional<Loop> Verify(const Map& map, KeyFrameId keyframe, KeyFrameId candidate,
                             std::span<const LoopEdge> loops);

  // Returns the loops that Detect() and Verify() rejected since the last call, after a pose was
  // found.
  std::vector<RefusedLoop> TakeRefused() { return std::exchange(refused_, {}); }

  // Resets the merge candidate, because the map was moved: the evidence of the last keyframes is no
  // longer valid.
  void Forget() { merge_candidate_.reset(); }

 private:
  // Keyframes that share landmarks, ascending, and the number of consecutive queries that returned
  // them.
  struct Place {
    std::vector<KeyFrameId> keyframes;
    int votes = 0;
  };
  // A transform between the worlds of two submaps that consecutive keyframes agree on.
  struct MergeCandidate {
    SubmapId own = kNoId, other = kNoId;  // roots
    LoopEdge edge;                        // of the newest of them
    int keyframes = 0;
  };
  struct Candidates {
    std::vector<KeyFrameId> loops;   // in the keyframe's world
    std::vector<KeyFrameId> merges;  // in other worlds
  };
  // Match of a keyframe with a place. share: LoopDetectorOptions::min_found.
  struct Found {
    Loop loop;
    int support = 0;
    double share = 0.0;
  };

  // Returns the most similar keyframes, at most that many of each kind.
  Candidates FindCandidates(const Map& map, KeyFrameId keyframe, int most) const;
  std::optional<Loop> DetectLoop(const Map& map, KeyFrameId keyframe,
                                 std::span<const KeyFrameId> candidates,
                                 std::span<const LoopEdge> loops);
  std::optional<Loop> DetectMerge(const Map& map, KeyFrameId keyframe,
                                  std::span<const KeyFrameId> candidates);
  // Returns whether the loop is possible given the drift between its keyframes; sets its chi2.
  bool IsWithinDrift(const Map& map, std::span<const LoopEdge> loops, Loop* loop);
  // Returns whether enough consecutive keyframes agree on the transform; stores it.
  bool Agrees(const Map& map, const LoopEdge& edge);
  // Returns the one of these merges with the most support on which another keyframe agrees and that
  // neither gravity nor depth contradicts.
  std::optional<Loop> AgreedMerge(const Map& map, std::vector<Found> found);
  // Returns whether gravity or the depth of the two submaps is inconsistent with their merge.
  bool Contradicts(const Map& map, const LoopEdge& edge);
  std::optional<Found> FindPlace(const Map& map, KeyFrameId keyframe, KeyFrameId candidate,
                                 const Relocalizer& relocalizer);
  Place PlaceOf(const Map& map, KeyFrameId keyframe) const;
  void Refuse(const LoopEdge& edge, std::string reason);

  const MeasurementModel& model_;
  LoopDetectorOptions options_;
  KeyFrameGraphOptions graph_;
  Relocalizer relocalizer_, last_relocalizer_;
  MapMatcher matcher_;
  DepthGrid grid_;
  std::vector<Place> places_;  // returned for the last keyframe
  std::optional<MergeCandidate> merge_candidate_;
  std::vector<RefusedLoop> refused_;
};

}  // namespace highwall
