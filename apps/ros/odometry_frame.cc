#include "ros/odometry_frame.h"

#include <vector>

#include <highwall/frontend/map/map.h>

namespace highwall::apps {

std::optional<Pose> OdometryFrame::LastIn(SubmapId world, const Map& map) const {
  if (last_->anchor == kNoId || map.RootOf(last_->anchor) != world) return std::nullopt;
  return map.ResolvePose(last_->anchor) * last_->T_AC;
}

Pose OdometryFrame::Advance(const FrameResult& result, const Map& map) {
  Pose T_OC = result.T_WC;
  if (last_) {
    const std::optional<Pose> T_WL = LastIn(result.submap, map);
    T_OC = T_WL ? last_->T_OC * (T_WL->Inverse() * result.T_WC) : last_->T_OC;
  }
  T_WO_ = result.T_WC * T_OC.Inverse();
  if (result.mapping) anchor_ = result.mapping->keyframe;
  if (anchor_ == kNoId || map.RootOf(anchor_) != result.submap) {
    const std::vector<KeyFrameId> keyframes = map.KeyFramesOf(result.submap);
    anchor_ = keyframes.empty() ? KeyFrameId(kNoId) : keyframes.back();
  }
  last_ = Last{.anchor = anchor_, .T_AC = {}, .T_OC = T_OC};
  if (anchor_ != kNoId) last_->T_AC = map.ResolvePose(anchor_).Inverse() * result.T_WC;
  return T_OC;
}

}  // namespace highwall::apps
