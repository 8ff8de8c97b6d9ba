#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/pose/pose_constraint.h>

#include "tracking/constant_velocity.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Returns whether a camera can have moved so far within dt [s], by whatever motion.
bool IsReachable(const Pose& motion, double dt);

// What the tracker remembers between frames. Functions that take a frame need a last frame.
struct TrackerState {
  std::optional<TrackedFrame> last;  // the last frame tracked
  int last_support = 0;              // support of its pose
  Stamp last_landmarks = 0;          // of the last frame with a pose from landmarks
  double mean_match_ratio = 0.0;     // mean match ratio (TrackedFrame::found); 0: unknown
  ConstantVelocity velocity;         // at the last frame
  bool is_continuous = false;        // whether the camera came there by continuous motion

  // Returns the time [s] from the last frame tracked to `frame`.
  double SinceLast(const Frame& frame) const;
  // Returns the pose of a frame by extrapolation of the last one at constant velocity.
  Pose Extrapolate(const Frame& frame) const;
  // Returns the motion expected at the next frame: that of `predicted`, or the last one; zero if
  // the camera was lost.
  Twist Motion(const PoseConstraint* predicted) const;
  // Returns whether the camera may have come here by continuous motion; otherwise twists are
  // meaningless.
  bool IsContinuous(const Twist& expected, const TrackedFrame& tracked) const;
  // Returns whether a camera can have come here from the last frame, by whatever motion.
  bool IsReachable(const TrackedFrame& tracked) const;
  // Returns the reference keyframe of the last frame and those that share most landmarks with it.
  std::vector<KeyFrameId> AroundReference(const Map& map, std::size_t most) const;
};

}  // namespace highwall
