#pragma once

#include <optional>

#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "map/map_matcher.h"
#include "pose/direct_alignment.h"
#include "tracking/frame_solver.h"
#include "tracking/pose_hypothesis.h"
#include "tracking/tracker_parameters.h"
#include "tracking/tracker_state.h"

namespace highwall {

// Proposes the pose by direct alignment of the whole image with the reference keyframe or else the
// last frame, with the landmarks that are consistent with it, where nothing else gave a pose and no
// IMU predicts it.
class WholeImageSource : public PoseSource {
 public:
  // All must outlive it. grid: of the depth grids.
  WholeImageSource(const MapMatcher& matcher, const TrackerOptions& options,
                   const TrackerParameters& parameters, const DepthGrid& grid,
                   const FrameSolver& solver, const TrackerState& state);

  bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const override;
  PoseHypothesis Propose(const TrackingQuery& query) const override;

 private:
  std::optional<DirectAlignment> AlignWith(const KeyFrame& reference, const Frame& frame) const;
  std::optional<DirectAlignment> AlignWithLast(const Frame& frame) const;
  // Matches the landmarks of the reference keyframe and its neighbours around the pose that the
  // query predicts; empty if too few are consistent with it.
  std::optional<TrackedFrame> MatchLandmarks(const TrackingQuery& query) const;

  const MapMatcher& matcher_;
  const TrackerOptions& options_;
  DirectAligner aligner_;
  const FrameSolver& solver_;
  const TrackerState& state_;
};

}  // namespace highwall
