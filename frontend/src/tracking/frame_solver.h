#pragma once

#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "pose/surface_matcher.h"
#include "tracking/tracked_frame.h"
#include "tracking/tracker_state.h"
#include "tracking/tracking_query.h"

namespace highwall {

class RunProfile;

// Minimum support (PoseSolverOptions) of a pose after the first match against the last frame or
// keyframe; and of any pose that an IMU predicts, which exposes wrong matches.
inline constexpr int kMinMotionSupport = 15;
inline constexpr int kMinPredictedSupport = 12;
// The same by points and lines of a pose by surfaces.
inline constexpr int kMinSurfaceSupport = 6;

// Fallback constraint on a pose, in addition to points and lines.
enum class FallbackConstraint { kNone, kSurfaces };

// Estimates the pose of a frame from its matches.
class FrameSolver {
 public:
  // All must outlive it. grid: of the depth grids. profile: null: none.
  FrameSolver(const MeasurementModel& model, const TrackerOptions& options, const DepthGrid& grid,
              const TrackerState& state, RunProfile* profile = nullptr)
      : model_(model), options_(options), grid_(grid), state_(state), profile_(profile) {}

  // Estimates the pose from the matches of `tracked`, and the prediction of the query as a prior;
  // unmatches outliers. False if too few remain.
  bool Solve(const TrackingQuery& query, int min_support, FallbackConstraint fallback,
             TrackedFrame* tracked) const;

 private:
  // Returns rows on the planar patches of the reference keyframe of the last frame; none if it has
  // no depth.
  std::vector<PointToPlaneRow> MatchSurfaces(const TrackedFrame& tracked, const Map& map) const;

  const MeasurementModel& model_;
  const TrackerOptions& options_;
  const DepthGrid& grid_;
  const TrackerState& state_;
  RunProfile* const profile_;
};

}  // namespace highwall
