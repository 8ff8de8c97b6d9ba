#pragma once

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/tracking/options.h>

#include "tracking/tracked_frame.h"

namespace highwall {

// When a frame becomes a keyframe.
class KeyFramePolicy {
 public:
  explicit KeyFramePolicy(const KeyFramePolicyOptions& options);

  // A first frame with enough depth to start a map.
  bool CanStart(const FrameFeatures& features) const;
  // The frame sees too little of its reference keyframe, or much that is not mapped, or the last
  // keyframe was long ago: with an IMU, which ties keyframes the better the nearer they are in
  // time, in any case, else unless the camera stands still.
  bool Wants(const TrackedFrame& tracked, const Map& map, Stamp last_keyframe,
             bool with_imu = false) const;

 private:
  KeyFramePolicyOptions options_;
};

}  // namespace highwall
