#pragma once

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/tracking/tracker.h>

namespace highwall {

struct KeyFramePolicyOptions {
  int min_features = 200;    // >= 6: with depth, points plus four times lines, to start a map
  double min_share = 0.75;   // (0, 1]: of the reference keyframe's landmarks found again
  int max_gap = 10;          // [frames] >= 1: since the last keyframe
  int wanted_tracked = 100;  // >= 0: a keyframe is due when fewer points with depth are tracked
  int wanted_new = 70;       // >= 0: than this and more than that wait to become landmarks

  void Validate() const;
};

// When a frame becomes a keyframe.
class KeyFramePolicy {
 public:
  explicit KeyFramePolicy(const KeyFramePolicyOptions& options);

  // A first frame with enough depth to start a map.
  bool CanStart(const FrameFeatures& features) const;
  // The frame sees too little of its reference keyframe, or much that is not mapped.
  bool Wants(const TrackedFrame& tracked, const Map& map, std::int64_t last_keyframe_index) const;

 private:
  KeyFramePolicyOptions options_;
};

}  // namespace highwall
