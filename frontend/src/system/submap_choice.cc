// Parts of SlamSystem that switch to another submap.
#include <algorithm>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

#include "system/slam_system_impl.h"

namespace highwall {

void SlamSystem::Impl::ChooseSubmap(TrackedFrame& tracked, FrameResult& result) {
  if (tracked.state == TrackingState::kTracking && tracked.relocalized) {
    const SubmapId found_in = map_.keyframe(tracked.reference)->submap;
    if (map_.Root(found_in) != map_.Root(submap_)) {
      LeaveSubmap(result);
      submap_ = found_in;
      submap_keyframes_ = kMinSubmapKeyFrames;  // mature: it was kept
      last_keyframe_ = kNoId;
      if (inertial_) inertial_->Restart();
    }
  }
  tracked.submap = submap_;
}

bool SlamSystem::Impl::CanBegin(const TrackedFrame& tracked) const {
  if (tracked.state == TrackingState::kLost) {
    if (!options_.submaps.enabled || options_.localize_only) return false;
    // The timeout of a short-lived submap is no longer than its life.
    const double lived = submap_keyframes_ < kMinSubmapKeyFrames
                             ? clock_.Seconds(submap_begin_, *posed_)
                             : options_.submaps.lost_timeout;
    const double waited = clock_.Seconds(*posed_, tracked.frame.stamp);
    if (waited < std::min(options_.submaps.lost_timeout, lived)) return false;
  }
  return policy_->CanStart(*tracked.frame.features);
}

void SlamSystem::Impl::BeginSubmap(TrackedFrame& tracked, FrameResult& result) {
  LeaveSubmap(result);
  if (submap_keyframes_ > 0) {
    submap_ = map_.AddSubmap();
    result.begins_submap = true;
    if (inertial_) inertial_->Restart();
  }
  submap_keyframes_ = 0;
  submap_begin_ = tracked.frame.stamp;
  last_keyframe_ = kNoId;
  tracker_.Forget();
  tracked.submap = submap_;
  tracked.state = TrackingState::kTracking;
  tracked.T_WC = FirstPose(tracked.frame.stamp);
}

Pose SlamSystem::Impl::FirstPose(Stamp stamp) const {
  // W has z up and x forward for a camera held horizontally (x right, y down, z forward).
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Pose level = Pose::FromMatrix(T);
  if (!inertial_) return level;
  const auto up_C = inertial_->UpInCamera(stamp);
  if (!up_C) return level;
  const Eigen::Vector3d up_W = level.q() * *up_C;
  return Pose(Eigen::Quaterniond::FromTwoVectors(up_W, Eigen::Vector3d::UnitZ()) * level.q(),
              Eigen::Vector3d::Zero());
}

void SlamSystem::Impl::LeaveSubmap(FrameResult& result) {
  const bool joined = map_.Root(submap_) != submap_;
  if (submap_keyframes_ >= kMinSubmapKeyFrames || joined) return;
  // A submap that is being merged is kept: the frames in it will be relocalized.
  if (loop_closer_.IsClosing()) return;
  worker_.Drop(map_, submap_);
  result.drops_submap = map_.NumKeyFramesOf(submap_) > 0;
  RememberDropped();
  map_.RemoveSubmap(submap_);
  tracked_.Forget(submap_, map_);
}

}  // namespace highwall
