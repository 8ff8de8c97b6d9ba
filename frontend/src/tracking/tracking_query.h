#pragma once

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/pose/pose_constraint.h>

namespace highwall {

// What the pose of a frame is estimated from. Refers to its parts, which must outlive it.
struct TrackingQuery {
  const Frame& frame;
  const Map& map;
  const PoseConstraint* prediction = nullptr;  // prior on the pose, such as by an IMU; null: none

  // Returns the same query with another prior.
  TrackingQuery With(const PoseConstraint* prior) const { return {frame, map, prior}; }
  TrackingQuery WithoutPrediction() const { return With(nullptr); }
};

}  // namespace highwall
