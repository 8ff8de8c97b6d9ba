#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "map/map_matcher.h"
#include "pose/degeneracy.h"
#include "pose/pose_observations.h"
#include "pose/pose_solver.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Features that have a landmark.
template <class LandmarkId>
std::vector<bool> Taken(const std::vector<LandmarkId>& landmarks) {
  std::vector<bool> taken(landmarks.size());
  std::transform(landmarks.begin(), landmarks.end(), taken.begin(),
                 [](LandmarkId id) { return id != kNoId; });
  return taken;
}

// Gives features the landmarks that they were found to be.
template <class LandmarkId>
void Apply(const std::vector<std::pair<int, LandmarkId>>& matches,
           std::vector<LandmarkId>& landmarks) {
  for (const auto& [feature, id] : matches) landmarks[static_cast<std::size_t>(feature)] = id;
}

// A frame with a pose and no landmark yet.
TrackedFrame Unmatched(const Frame& frame, const Pose& T_WC);

// The landmarks that a frame was found to see, and the features that see them.
struct LandmarkObservations {
  std::vector<PosePoint> points;
  std::vector<PoseLine> lines;
  std::vector<std::size_t> point_features, line_features;
};

// What is no longer in the map, or not in front of the camera, is unmatched.
LandmarkObservations LandmarksSeen(const MeasurementModel& model, const Map& map,
                                   TrackedFrame& tracked);

// The frame with the pose that its observations gave; outliers are unmatched.
void TakePose(const LandmarkObservations& seen, const PoseSolution& solution,
              const DegeneracyOptions& degeneracy, TrackedFrame* tracked);

// Matches a frame, matched in part, with all that the keyframes see that share most landmarks with
// it, most of them at most.
struct LandmarksInView {
  std::vector<PointId> points;  // that were to be seen from its pose, matched or not
  std::vector<LineId> lines;
};
LandmarksInView MatchAround(const MapMatcher& matcher, const Map& map, int most,
                            TrackedFrame* tracked);

}  // namespace highwall
