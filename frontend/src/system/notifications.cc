// Callbacks of SlamSystem.
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/internal/stage_timer.h>

#include "system/slam_system_impl.h"

namespace highwall {

bool MoveKeyframes(const std::vector<LoopReport>& loops) {
  return std::ranges::any_of(loops, [](const LoopReport& report) {
    return report.accepted && (!report.bundle || report.bundle->usable);
  });
}

void SlamSystem::Impl::Notify(const FrameResult& result, const RgbdImage& image, bool moved) {
  const StageTimer timer(profile_, "callbacks");
  const bool levelled = result.inertial && result.inertial->T_gravity;
  const bool follows_factors = result.factors && result.factors->accepted;
  moved |= levelled || follows_factors || result.drops_submap || MoveKeyframes(result.loops);
  Collect(result, image, moved);  // first: a callback may throw
  if (callbacks_.on_keyframe && result.mapping) {
    callbacks_.on_keyframe(*map_.keyframe(result.mapping->keyframe), image);
  }
  if (callbacks_.on_submap && result.begins_submap) callbacks_.on_submap(result.submap);
  Notify(result.loops);
  if (moved) NotifyMoved();
  NotifyFindings();
  EmitKeyframes(result.stamp);
}

void SlamSystem::Impl::Notify(const std::vector<LoopReport>& loops) const {
  for (const LoopReport& report : loops) {
    if (callbacks_.on_loop) callbacks_.on_loop(report);
    if (callbacks_.on_merge && report.merge && report.accepted) callbacks_.on_merge(report);
  }
}

void SlamSystem::Impl::NotifyMoved() const {
  if (callbacks_.on_map) callbacks_.on_map(map_);
}

void SlamSystem::Impl::CheckLens(bool at_end) {
  const StageTimer timer(profile_, "lens");
  auto finding = at_end ? lens_check_.Finish(map_, model_, submap_, last_given_keyframe_)
                        : lens_check_.Update(map_, model_, submap_, last_given_keyframe_);
  if (finding) Find(std::move(*finding));
}

void SlamSystem::Impl::Find(SensorFinding finding) {
  if (verdict_.Add(finding)) new_findings_.push_back(std::move(finding));
}

void SlamSystem::Impl::NotifyFindings() {
  for (const SensorFinding& finding : std::exchange(new_findings_, {})) {
    if (callbacks_.on_finding) callbacks_.on_finding(finding);
  }
}

KeyframeRelease::MaskOf SlamSystem::Impl::DynamicMasks() const {
  return [this](KeyFrameId id) { return DynamicMaskOf(id); };
}

void SlamSystem::Impl::Collect(const FrameResult& result, const RgbdImage& image, bool moved) {
  if (!callbacks_.on_keyframes) return;
  if (moved) release_.Move();
  if (!result.mapping) return;
  release_.Add(result.mapping->keyframe, image, result.moving);
  for (const KeyFrameId culled : result.mapping->culled_keyframes) release_.Remove(culled);
}

void SlamSystem::Impl::EmitKeyframes(Stamp now) {
  if (!callbacks_.on_keyframes) return;
  const KeyframeEvent event = release_.Event(now, map_, DynamicMasks());
  if (!event.empty()) callbacks_.on_keyframes(event);
  release_.SetEmitted(now);
}

void SlamSystem::Impl::EmitAllKeyframes() {
  if (!callbacks_.on_keyframes) return;
  callbacks_.on_keyframes(waiting_keyframes());
  release_.SetLastEmitted();
}

std::optional<KeyframeView> SlamSystem::Impl::keyframe_view(KeyFrameId id,
                                                            const RgbdImage& image) const {
  KeyframeRelease one(0.0);
  RgbdImage corrected = image;
  corrected.depth = CorrectedDepth(id, image.depth);
  one.Add(id, corrected, {});
  std::vector<KeyframeView> views = one.Event(image.stamp, map_, DynamicMasks()).added;
  return views.empty() ? std::nullopt : std::optional(std::move(views.front()));
}

KeyframeEvent SlamSystem::Impl::waiting_keyframes() const {
  return release_.LastEvent(map_, DynamicMasks());
}

}  // namespace highwall
