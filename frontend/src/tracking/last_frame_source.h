#pragma once

#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "tracking/frame_solver.h"
#include "tracking/pose_hypothesis.h"
#include "tracking/tracker_parameters.h"
#include "tracking/tracker_state.h"

namespace highwall {

// Proposes the pose at which the landmarks of the last frame are found around their places by the
// prediction, or at constant velocity.
class LastFrameSource : public PoseSource {
 public:
  // All must outlive it.
  LastFrameSource(const MapMatcher& matcher, const TrackerOptions& options,
                  const TrackerParameters& parameters, const FrameSolver& solver,
                  const TrackerState& state)
      : matcher_(matcher),
        options_(options),
        parameters_(parameters),
        solver_(solver),
        state_(state) {}

  bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const override;
  PoseHypothesis Propose(const TrackingQuery& query) const override;

 protected:
  PoseHypothesis ProposeWith(FallbackConstraint fallback, const TrackingQuery& query) const;
  const TrackerOptions& options() const { return options_; }
  const TrackerState& state() const { return state_; }

 private:
  // Matches a frame at its rough pose with the landmarks of the last one. radius_scale: of the
  // search for points.
  void MatchLast(const TrackingQuery& query, double radius_scale, TrackedFrame* tracked) const;
  // Returns whether few of the first matches are consistent with their pose.
  bool IsInconsistent(const TrackedFrame& rough) const;
  // Returns the predicted image shift [px] until `frame` at constant velocity.
  double Shift(const Frame& frame) const;

  const MapMatcher& matcher_;
  const TrackerOptions& options_;
  const TrackerParameters& parameters_;
  const FrameSolver& solver_;
  const TrackerState& state_;
};

// The same with surfaces as a fallback constraint, where nothing else gave a pose and no IMU
// predicts it.
class SurfaceSource : public LastFrameSource {
 public:
  using LastFrameSource::LastFrameSource;

  bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const override;
  PoseHypothesis Propose(const TrackingQuery& query) const override;
};

}  // namespace highwall
