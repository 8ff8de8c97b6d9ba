#pragma once

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// The pose of a camera anchored to a keyframe, which it follows when the map is adjusted.
struct AnchoredPose {
  KeyFrameId reference = kNoId;
  Pose T_reference_C;

  // Anchors the current pose T_WC. reference: a keyframe of the map, also one that was removed.
  static AnchoredPose At(const Map& map, KeyFrameId reference, const Pose& T_WC) {
    return {reference, map.ResolvePose(reference).Inverse() * T_WC};
  }
  Pose T_WC(const Map& map) const { return map.ResolvePose(reference) * T_reference_C; }
};

// A frame with a pose.
struct PosedFrame {
  Stamp stamp = 0;
  AnchoredPose pose;
};

}  // namespace highwall
