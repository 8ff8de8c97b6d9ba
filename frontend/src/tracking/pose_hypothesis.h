#pragma once

#include <optional>
#include <utility>

#include <highwall/frontend/pose/pose_constraint.h>

#include "tracking/frame_solver.h"
#include "tracking/local_match.h"
#include "tracking/tracked_frame.h"
#include "tracking/tracking_diagnostics.h"
#include "tracking/tracking_query.h"

namespace highwall {

// What a hypothesis comes from: it decides what may refute the pose.
enum class PoseOrigin {
  kMotion,     // the last frame and the motion since
  kReference,  // the reference keyframe of the last frame, recognized without the motion
  kPlace,      // a place that was recognized independently of the last frame
  kSurfaces,   // the last frame, with surfaces as a fallback constraint
  kImage,      // the alignment of the whole image
};

// A pose of a frame that is to be verified.
struct PoseHypothesis {
  PoseOrigin origin = PoseOrigin::kMotion;
  std::optional<TrackedFrame> rough{};    // first matches and their pose; empty: there is none
  bool is_inconsistent = false;           // few of the first matches are consistent with the pose
  std::optional<PoseConstraint> prior{};  // takes part in the pose
  FallbackConstraint fallback = FallbackConstraint::kNone;
  // The result if the local map has no matches: a pose without landmarks.
  std::optional<TrackedFrame> without_landmarks{};
  double correlation = 1.0;  // of the grey levels with those that the image was aligned with
  AttemptDiagnostics diagnostics{};
};

// Result of the verification of a hypothesis.
struct Verification {
  std::optional<LocalMatch> match{};  // empty: there was none, or it was refuted
  bool is_ambiguous = false;          // the motion gives no certain pose: try to recognize a place
  AttemptDiagnostics diagnostics{};
};

// The search for the pose of a frame, as far as it has come.
struct PoseSearch {
  std::optional<LocalMatch>
      best{};                 // the pose with most support; the earlier one of two equal ones
  bool is_ambiguous = false;  // of the last verification
  bool prediction_rejected = false;  // `best` is inconsistent with the prediction
  TrackingDiagnostics diagnostics{};

  // Takes the pose of another search if it has more support; returns whether it has.
  bool Take(std::optional<LocalMatch> match) {
    if (!match || (best && match->Support() <= best->Support())) return false;
    best = std::move(match);
    return true;
  }
  void Add(Verification verification) {
    diagnostics.Add(verification.diagnostics);
    is_ambiguous = verification.is_ambiguous;
    Take(std::move(verification.match));
  }
};

// A source of hypotheses.
class PoseSource {
 public:
  virtual ~PoseSource() = default;

  // Returns whether its hypothesis is to be tried after what was found so far.
  virtual bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const = 0;
  virtual PoseHypothesis Propose(const TrackingQuery& query) const = 0;
};

}  // namespace highwall
