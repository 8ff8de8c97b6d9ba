#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_observations.h>
#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "pose/degeneracy.h"
#include "tracking/landmarks_around.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Returns for each feature whether it has a landmark.
template <class LandmarkId>
std::vector<bool> Taken(const std::vector<LandmarkId>& landmarks) {
  std::vector<bool> taken(landmarks.size());
  std::transform(landmarks.begin(), landmarks.end(), taken.begin(),
                 [](LandmarkId id) { return id != kNoId; });
  return taken;
}

// Assigns the matched landmarks to features.
template <class LandmarkId>
void Apply(const std::vector<std::pair<int, LandmarkId>>& matches,
           std::vector<LandmarkId>& landmarks) {
  for (const auto& [feature, id] : matches) landmarks[static_cast<std::size_t>(feature)] = id;
}

// Returns the support of the matched landmarks.
int MatchedSupport(const PerKind<LandmarkIds>& landmarks);

// Returns a frame with a pose and without matched landmarks.
TrackedFrame Unmatched(const Frame& frame, const Pose& T_WC);

// Observations of the landmarks matched with a frame, and the features they belong to.
struct LandmarkObservations : PerKind<PoseObservations> {
  template <class Landmark>
  using Indices = std::vector<std::size_t>;
  PerKind<Indices> features;
};

// Collects the observations. Unmatches landmarks that are no longer in the map or not in front of
// the camera.
LandmarkObservations LandmarksSeen(const MeasurementModel& model, const Map& map,
                                   TrackedFrame& tracked);

// Sets the pose estimated from the observations; unmatches outliers.
void TakePose(const LandmarkObservations& seen, const PoseSolution& solution,
              const DegeneracyOptions& degeneracy, TrackedFrame* tracked);

// Estimates the pose from the landmarks that a frame is matched to, by images alone; unmatches
// outliers. Returns false, and leaves the pose, if fewer than TrackerOptions::min_support agree.
bool SolveFromLandmarks(const MeasurementModel& model, const Map& map,
                        const TrackerOptions& options, TrackedFrame* tracked);

// Returns the keyframes that share most landmarks with a frame, most first, at most `most`.
std::vector<KeyFrameId> ClosestObservers(const Map& map, const TrackedFrame& tracked, int most);

// Matches a partly matched frame with all landmarks of the keyframes that share most landmarks with
// it, at most `most` keyframes. Returns the landmarks predicted to be visible from its pose,
// matched or not. around: of the map, where several frames are matched; may be null.
PerKind<LandmarkIds> MatchAround(const MapMatcher& matcher, const Map& map, int most,
                                 TrackedFrame* tracked, LandmarksAround* around = nullptr);

// The landmarks that a frame should have observed, and those that it did (MapPoint::visible,
// MapPoint::found).
struct LandmarkCounts {
  PerKind<LandmarkIds> in_view;
  PerKind<LandmarkIds> found;  // per feature, kNoId where unmatched

  // Counts them in the map.
  void AddTo(Map* map) const;
};

}  // namespace highwall
