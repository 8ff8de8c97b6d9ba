#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "tracking/dynamic_features.h"
#include "tracking/frame_solver.h"
#include "tracking/pose_hypothesis.h"
#include "tracking/tracker_parameters.h"
#include "tracking/tracker_state.h"

namespace highwall {

// Verifies hypotheses on the pose of a frame: matches the local map from the rough pose, with
// dynamic objects masked out, and rejects the pose if few landmarks agree or if depth contradicts
// it.
class PoseVerifier {
 public:
  // All must outlive it.
  PoseVerifier(const MeasurementModel& model, const TrackerOptions& options,
               const TrackerParameters& parameters, const MapMatcher& matcher,
               const DynamicFeatures& moving, const FrameSolver& solver, const TrackerState& state)
      : model_(model),
        options_(options),
        parameters_(parameters),
        matcher_(matcher),
        moving_(moving),
        solver_(solver),
        state_(state) {}

  Verification Verify(const TrackingQuery& query, PoseHypothesis hypothesis) const;

 private:
  struct StaticMatch {
    std::optional<LocalMatch> match{};
    double masked_share = 0.0;  // of the features, on dynamic objects
  };
  // Matches the local map with a frame at a rough pose, with dynamic objects masked out.
  StaticMatch MatchStaticScene(const TrackingQuery& query, TrackedFrame rough,
                               FallbackConstraint fallback) const;
  // The same with the features that are given; empty if too few matches are consistent.
  std::optional<LocalMatch> MatchLocalMap(const TrackingQuery& query, TrackedFrame rough,
                                          FallbackConstraint fallback) const;
  // Re-verifies the static pose: returns the frame at a pose from landmarks and surfaces together
  // if half or more of the dynamic mask arises only because the rough pose is slightly off.
  // Landmarks elsewhere of at least half of `support` must agree, and so must the depth of
  // keyframes. Empty if there is no such pose.
  std::optional<TrackedFrame> Reverified(const TrackingQuery& query, TrackedFrame rough,
                                         int support) const;
  // Returns whether a match that the hypothesis led to is not of the place it claims.
  bool IsRefuted(const PoseHypothesis& hypothesis, const LocalMatch& match, const Map& map) const;
  // Returns whether few landmarks in view agree, or far fewer than in the last frame.
  bool IsDoubtful(const LocalMatch& match) const;
  // Returns whether fewer landmarks in view are matched than in most frames.
  bool FindsLittle(const LocalMatch& match) const;
  // Returns whether its depth is inconsistent with that of the keyframes whose landmarks it sees.
  bool Contradicts(const LocalMatch& match, const Map& map) const;
  // Returns whether its depth is inconsistent with that of these keyframes.
  bool Contradicts(const TrackedFrame& tracked, std::span<const KeyFrameId> views,
                   const Map& map) const;

  const MeasurementModel& model_;
  const TrackerOptions& options_;
  const TrackerParameters& parameters_;
  const MapMatcher& matcher_;
  const DynamicFeatures& moving_;
  const FrameSolver& solver_;
  const TrackerState& state_;
};

}  // namespace highwall
