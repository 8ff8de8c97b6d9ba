#pragma once

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/tracking/options.h>

#include "tracking/tracked_frame.h"

namespace highwall {

// Decides whether a frame becomes a keyframe.
class KeyFramePolicy {
 public:
  explicit KeyFramePolicy(const KeyFramePolicyOptions& options);

  // Returns whether a first frame has enough features with depth to start a map.
  bool CanStart(const FrameFeatures& features) const;
  // Returns whether the frame sees too little of its reference keyframe, or sees much that is not
  // mapped, or the last keyframe is too old. The last holds in any case with an IMU, whose factors
  // are the more accurate the closer keyframes are in time, otherwise only if the camera is not
  // stationary.
  bool Wants(const TrackedFrame& tracked, const Map& map, Stamp last_keyframe,
             bool with_imu = false) const;

 private:
  KeyFramePolicyOptions options_;
};

}  // namespace highwall
