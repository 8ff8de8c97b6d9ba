#pragma once

#include <span>

#include <highwall/core/abi.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/pose/pose_report.h>

namespace [[gnu::visibility("default")]] highwall {

// A frame with a pose that may become a keyframe; valid during the call that it is passed to.
struct KeyFrameCandidate {
  const Frame& frame;
  TrackingState state = TrackingState::kTracking;  // or kInertial: the IMU alone gives the pose
  Pose T_WC{};
  SubmapId submap = kFirstSubmap;  // that the keyframe would join
  // The keyframe that shares most landmarks; the last one with kInertial. It may have been removed.
  KeyFrameId reference = kNoId;
  std::span<const PointId> points{};  // per point feature of the frame, kNoId where unmatched
  std::span<const LineId> lines{};    // per line feature
  int num_points = 0, num_lines = 0;  // matched
  // [s] from the last keyframe; where frames are a second or more apart, as if they came at 30 Hz
  double since_keyframe = 0.0;
  double since_image = 0.0;  // [s] from the last frame with a pose from its image; 0: this one
  bool with_imu = false;
};

// Decides which frames become keyframes. A user-defined policy replaces StandardKeyFramePolicy in
// SlamSystem. Functions are called on the thread that calls Track(), which would be left half done
// by an exception: they must not throw.
class KeyFramePolicy {
 public:
  virtual ~KeyFramePolicy();

  // Returns whether a frame without a pose may begin a map or a submap, of which it then is the
  // first keyframe: whether it has enough features with depth.
  virtual bool CanStart(const FrameFeatures& features) = 0;
  // Returns whether the frame becomes a keyframe. Called for every frame that has a pose in a map
  // that has keyframes, unless the system only localizes or the image repeats the one before.
  virtual bool Wants(const KeyFrameCandidate& candidate, const Map& map) = 0;

 protected:
  KeyFramePolicy() = default;
  KeyFramePolicy(const KeyFramePolicy&) = default;
  KeyFramePolicy& operator=(const KeyFramePolicy&) = default;
};

}  // namespace highwall
