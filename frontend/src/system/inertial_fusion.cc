// Parts of SlamSystem that fuse images with the IMU.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/seen_landmarks.h>
#include <highwall/internal/stage_timer.h>

#include "inertial/inertial_prior.h"
#include "system/slam_system_impl.h"

namespace highwall {

InertialOdometry::Observation SlamSystem::Impl::Observe(const TrackedFrame& tracked) {
  InertialOdometry::Observation observation;
  observation.image = tracked.frame.stamp;
  const double sharpness = tracked.frame.features->sharpness;
  if (usual_sharpness_ > 0.0) observation.sharpness = sharpness / usual_sharpness_;
  FollowSharpness(*tracked.frame.features);
  if (last_points_ > 0) {
    observation.tracked_share =
        std::min(1.0, static_cast<double>(tracked.num_points) / last_points_);
  }
  last_points_ = tracked.num_points;
  if (tracked.state == TrackingState::kTracking) {
    last_visual_ = tracked.frame.stamp;
    observation.visual = MakeVisualPose(tracked.T_WC, tracked.information, tracked.gradient,
                                        tracked.error, options_.inertial.visual_noise);
  }
  return observation;
}

void SlamSystem::Impl::Fuse(InertialOdometry::Observation observation, TrackedFrame& tracked,
                            FrameResult& result) {
  const StageTimer timer(profile_, "imu");
  observation.see = [&] { return FindSeen(map_, tracked.frame.features, tracked, tracked.error); };
  // The result of a loop in progress would be lost.
  observation.keeps_level = loop_closer_.IsClosing();
  image_pose_.reset();
  const bool was_running = inertial_->estimate().has_value();
  result.inertial = inertial_->Update(observation);
  if (result.inertial->finding) Find(*result.inertial->finding);
  if (result.inertial->abandoned) tracked.T_WC = ForgetImu() * tracked.T_WC;
  if (result.inertial->extrinsics) {
    model_.SetExtrinsics(inertial_->T_BC());
    pending_.SetExtrinsics(inertial_->T_BC().Inverse());
  }
  if (const std::optional<Pose>& T_gravity = result.inertial->T_gravity) {
    worker_.Drop(map_, submap_);
    map_.Transform(*T_gravity, submap_);
    tracker_.Transform(*T_gravity);
    tracked.T_WC = *T_gravity * tracked.T_WC;
    tracked.information = RotatedInformation(tracked.information, T_gravity->R());
  }
  if (const double weight = result.inertial->weight; weight > 0.0) {
    const double seconds = ToSeconds(observation.image - last_fused_);
    imu_constrained_time_ += seconds;
    weighed_ += seconds * weight;
  }
  last_fused_ = observation.image;
  if (!was_running && result.inertial->T_gravity) {
    AddReadingsBeforeStart();
    CorrectMotionsBeforeStart();
  }
  if (const auto gravity_W = inertial_->gravity_W()) map_.SetGravity(gravity_W, submap_);
  if (const std::optional<Pose> T_WC = inertial_->T_WC()) {
    if (tracked.state == TrackingState::kTracking) {
      image_pose_ = AnchoredPose::At(map_, tracked.reference, tracked.T_WC);
    }
    if (tracked.state == TrackingState::kLost) {
      tracked.state = TrackingState::kInertial;
      tracked.reference =
          last_keyframe_ != kNoId ? last_keyframe_ : tracker_.reference().value_or(kNoId);
    }
    tracked.T_WC = *T_WC;
    if (tracked.state == TrackingState::kTracking) tracker_.Correct(*T_WC);
  }
}

std::shared_ptr<const ReadingsBetween> SlamSystem::Impl::ReadingsFromBefore() {
  const bool is_fused = inertial_->estimate().has_value();
  const auto before =
      std::exchange(fused_before_, is_fused ? std::optional(last_fused_) : std::nullopt);
  return is_fused && before ? Readings(*before, last_fused_) : nullptr;
}

std::shared_ptr<const ReadingsBetween> SlamSystem::Impl::Readings(Stamp from, Stamp to) const {
  const InertialEstimate now = *inertial_->estimate();
  // By the present time offset, so that the readings last as long as the images are apart.
  const Stamp offset = now.stamp - last_fused_;
  const auto motion = inertial_->AllBetween(from + offset, to + offset);
  if (!motion || !motion->HasInformation() || inertial_->weight() <= 0.0) return nullptr;
  return std::make_shared<const ReadingsBetween>(
      ReadingsBetween{.before = from,
                      .samples = {motion->samples().begin(), motion->samples().end()},
                      .noise = motion->options().noise,
                      .weight = inertial_->weight(),
                      .contradicted = inertial_->IsContradicted(from + offset, to + offset),
                      .bias = now.bias,
                      .bias_sigma = now.covariance.diagonal().tail<6>().cwiseSqrt()});
}

void SlamSystem::Impl::AddReadingsBeforeStart() {
  const SubmapId root = map_.Root(submap_);
  std::vector<PosedFrame>& frames = *tracked_.mutable_frames();
  if (frames.empty() || map_.RootOf(frames.back().pose.reference) != root) return;
  fused_before_ = frames.back().stamp;
  for (std::size_t i = frames.size() - 1; i-- > 0;) {
    if (map_.RootOf(frames[i].pose.reference) != root || frames[i + 1].readings) return;
    frames[i + 1].readings = Readings(frames[i].stamp, frames[i + 1].stamp);
    if (!frames[i + 1].readings) return;
  }
}

void SlamSystem::Impl::CorrectMotionsBeforeStart() {
  // [ns] from a keyframe to the one that shows its velocity: poses that are 5 mm off make it
  // 0.02 m/s after the shorter, and gravity that is 0.015 rad off 0.06 m/s after the longer,
  // instead of 0.15 m/s from one frame to the next.
  constexpr Stamp kShortest = 250'000'000, kLongest = 750'000'000;
  if (options_.tracker.timing == FrameTimingMode::kIgnored) return;
  const InertialEstimate now = *inertial_->estimate();
  const Stamp offset = now.stamp - last_fused_;
  const Eigen::Vector3d gravity_W = *inertial_->gravity_W();
  const Pose T_CB = inertial_->T_BC().Inverse();
  const std::vector<KeyFrameId> keyframes = map_.KeyFramesOf(map_.Root(submap_));
  for (auto id = keyframes.begin(); id != keyframes.end(); ++id) {
    const KeyFrame& keyframe = *map_.keyframe(*id);
    if (*id <= last_given_keyframe_ || keyframe.motion) continue;  // given, or by the IMU already
    const auto later = std::find_if(id, keyframes.end(), [&](KeyFrameId other) {
      return map_.keyframe(other)->frame.stamp >= keyframe.frame.stamp + kShortest;
    });
    if (later == keyframes.end()) return;
    const KeyFrame& next = *map_.keyframe(*later);
    if (next.frame.stamp > keyframe.frame.stamp + kLongest) continue;
    const auto imu = inertial_->Between(keyframe.frame.stamp + offset, next.frame.stamp + offset);
    if (!imu) continue;
    sensor_.CorrectMotion(*id, CameraMotionBefore(*imu, now.bias, gravity_W, keyframe.T_WC * T_CB,
                                                  (next.T_WC * T_CB).p(), inertial_->T_BC()));
  }
}

Pose SlamSystem::Impl::ForgetImu() {
  // [keyframes] adjusted without the IMU, the newest ones, since tracking waits for it: an IMU that
  // is wrong from the beginning is given up before there are more.
  constexpr std::size_t kAdjusted = 60, kHeld = 60;
  const SubmapId root = map_.Root(submap_);
  sensor_.ForgetReadings();
  const Pose T_new_old = WithTracker([&] {
    worker_.Drop(map_, root);
    for (const KeyFrameId id : map_.keyframe_ids()) {
      auto& motion = map_.keyframe(id)->motion;
      if (!motion || id <= last_given_keyframe_) continue;
      motion->previous = kNoId;
      motion->from_previous = nullptr;
    }
    const std::vector<KeyFrameId> all = map_.KeyFramesOf(root);
    const std::size_t free = std::min(all.size(), kAdjusted);
    const std::size_t held = std::min(all.size() - free, kHeld);
    const std::span<const KeyFrameId> recent = std::span(all).last(free + held);
    AdjustBundle(map_, model_, recent.last(free), recent.first(held), kGlobalAdjustment, {},
                 std::max(1, options_.threads));
  });
  for (PosedFrame& frame : *tracked_.mutable_frames()) {
    frame.pose = frame.measured();
    frame.by_image.reset();
    frame.readings.reset();
  }
  if (last_given_keyframe_ == kNoId) map_.SetGravity(std::nullopt, submap_);
  NotifyMoved();
  return T_new_old;
}

std::optional<InertialState> SlamSystem::Impl::MotionSince(const KeyFrame* last) const {
  if (!inertial_) return std::nullopt;
  const std::optional<InertialEstimate> estimate = inertial_->estimate();
  if (!estimate) return std::nullopt;
  InertialState motion;
  motion.stamp = estimate->stamp;
  motion.v_WB = estimate->state.v_WB;
  motion.bias = estimate->bias;
  motion.bias_sigma = estimate->covariance.diagonal().tail<6>().cwiseSqrt();
  if (options_.inertial.estimate_time_offset) {
    motion.time_offset_sigma = inertial_->time_offset_sigma();
  }
  // The weight of an interval is the mean over its images. If combined as covariances, a single
  // low-weight image would suppress the whole interval.
  motion.weight =
      imu_constrained_time_ > 0.0 ? weighed_ / imu_constrained_time_ : inertial_->weight();
  if (last == nullptr || !last->motion) return motion;
  if (auto imu = inertial_->Between(last->motion->stamp, estimate->stamp)) {
    motion.previous = last->id;
    motion.from_previous = std::make_shared<const ImuPreintegration>(*std::move(imu));
  }
  return motion;
}

}  // namespace highwall
