#pragma once

#include <highwall/core/abi.h>
#include <highwall/frontend/tracking/keyframe_policy.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

// The policy of SlamSystem unless another one is given.
class StandardKeyFramePolicy final : public KeyFramePolicy {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit StandardKeyFramePolicy(const KeyFramePolicyOptions& options = {});

  bool CanStart(const FrameFeatures& features) override;
  // Returns whether the frame sees too little of its reference keyframe, or sees much that is not
  // mapped, or the last keyframe is too old. The last holds in any case with an IMU, whose factors
  // are the more accurate the closer keyframes are in time, otherwise only if the camera is not
  // stationary. A frame whose pose is from the IMU alone is wanted when images have given no pose
  // for half a second, and it could start a map: the camera is in a new place.
  bool Wants(const KeyFrameCandidate& candidate, const Map& map) override;

 private:
  KeyFramePolicyOptions options_;
  double since_keyframe_ = -1.0;  // [s] of the last candidate; -1: there was none
  // Points with depth but without a landmark in the first frame after the last keyframe, which had
  // made a landmark of every one: corners that are not found again.
  int unmatched_ = 0;
};

}  // namespace highwall
