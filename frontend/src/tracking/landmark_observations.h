#pragma once

#include <cstddef>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "pose/pose_observations.h"
#include "tracking/tracked_frame.h"

namespace highwall {

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

}  // namespace highwall
