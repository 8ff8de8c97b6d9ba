#pragma once

#include "tracking/pose_hypothesis.h"
#include "tracking/relocalizer.h"
#include "tracking/tracker_state.h"

namespace highwall {

// Proposes the pose by the descriptors of the last frame's reference keyframe, where the motion
// gives no certain pose.
class ReferenceKeyframeSource : public PoseSource {
 public:
  // Both must outlive it.
  ReferenceKeyframeSource(const Relocalizer& relocalizer, const TrackerState& state)
      : relocalizer_(relocalizer), state_(state) {}

  bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const override;
  PoseHypothesis Propose(const TrackingQuery& query) const override;

 private:
  const Relocalizer& relocalizer_;
  const TrackerState& state_;
};

// Proposes the pose in a place that the index of the map recognizes, where nothing else gave one.
class PlaceIndexSource : public PoseSource {
 public:
  // relocalizer: must outlive it.
  explicit PlaceIndexSource(const Relocalizer& relocalizer) : relocalizer_(relocalizer) {}

  bool IsDue(const TrackingQuery& query, const PoseSearch& so_far) const override;
  PoseHypothesis Propose(const TrackingQuery& query) const override;

 private:
  const Relocalizer& relocalizer_;
};

}  // namespace highwall
