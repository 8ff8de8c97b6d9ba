// Parts of SlamSystem that estimate poses of frames later than their images come.
#include <optional>

#include <highwall/internal/stage_timer.h>

#include "system/slam_system_impl.h"

namespace highwall {

ImageKnowledge SlamSystem::Impl::Knowledge() const {
  ImageKnowledge knowledge{.pattern = depth_pattern_.pattern()};
  if (sensor_.estimates_noise()) knowledge.noise = sensor_.noise();
  if (options_.tracker.timing != FrameTimingMode::kIgnored) knowledge.timing = sensor_.timing();
  return knowledge;
}

void SlamSystem::Impl::RefineFrames(FrameResult& result) {
  const StageTimer timer(profile_, "refined frames", &result.times.mapping);
  if (refiner_.HasResult()) refiner_.Finish(map_, tracked_.mutable_frames());
  if (backlog_.IsEmpty() || refiner_.IsFull()) refiner_.Begin(map_, Knowledge());
}

void SlamSystem::Impl::RememberLost(const TrackedFrame& tracked, Stamp stamp) {
  if (!options_.refinement.enabled) return;
  lost_frames_.Add({tracked.frame, stamp, tracker_.moved_by(), depth_pattern_.pattern(),
                    tracker_.usual_match_ratio()});
}

void SlamSystem::Impl::RememberDropped() {
  if (!options_.refinement.enabled) return;
  const double usual = tracker_.usual_match_ratio();
  for (const PosedFrame& posed : tracked_.frames()) {
    if (map_.RootOf(posed.pose.reference) != submap_) continue;
    const KeyFrame* const keyframe = map_.keyframe(posed.pose.reference);
    if (keyframe != nullptr && keyframe->frame.stamp == posed.measured_at()) {
      const RowMotion* const rows = sensor_.RowsOf(keyframe->id);
      lost_frames_.Add({keyframe->frame, posed.stamp, rows != nullptr ? *rows : RowMotion(),
                        depth_pattern_.pattern(), usual});
    } else if (std::optional<LostFrame> waiting = refiner_.Withdraw(posed.stamp)) {
      waiting->usual_match_ratio = usual;
      lost_frames_.Add(*std::move(waiting));
    }
  }
}

void SlamSystem::Impl::FinishFrames() {
  refiner_.FinishAll(map_, Knowledge(), tracked_.mutable_frames());
  tracked_.Insert(
      lost_frames_.Find(map_, Knowledge(), tracked_.frames(), tracker_.usual_match_ratio()), map_);
  if (!options_.refinement.smooth) return;
  const StageTimer timer(profile_, "smoothing of frames");
  tracked_.Smooth(map_, inertial_ ? std::optional(inertial_->T_BC()) : std::nullopt);
}

}  // namespace highwall
