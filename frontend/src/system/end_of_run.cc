// Parts of SlamSystem at the end of a run.
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/internal/stage_timer.h>

#include "system/slam_system_impl.h"

namespace highwall {
namespace {

// Number of keyframes that may have come too late for a loop to be confirmed.
constexpr std::size_t kNewest = 3;

}  // namespace

std::vector<LoopReport> SlamSystem::Impl::Finish() {
  const StageTimer timer(profile_, "end of all threads");
  FrameResult after_last;
  if (std::exchange(due_.loop_search, false)) LookForLoop(after_last);
  std::vector<LoopReport> reports = std::move(after_last.loops);
  bool moved = false;  // by factors
  const auto finish_factors = [&] {
    const auto report = factor_adjuster_.Finish(&map_);
    if (!report || !report->accepted) return;
    moved = true;
    depth_pattern_.Drop();  // its copy is of the map before
  };
  WithTracker([&] {
    mapper_.Finish(&map_);
    std::ranges::move(loop_closer_.Finish(&map_), std::back_inserter(reports));
    factor_adjuster_.Remember(map_, loop_closer_.TakeMovesByFactors());
    finish_factors();
    pending_.Attach(tracked_.frames(), &map_);
    std::ranges::move(CloseLastLoop(), std::back_inserter(reports));
    for (const SubmapId root : map_.roots()) {
      factor_adjuster_.BeginLast(map_, root, loop_closer_.loops());
      finish_factors();
    }
  });
  FinishFrames();
  Notify(reports);
  if (moved || MoveKeyframes(reports)) NotifyMoved();
  CheckLens(true);
  NotifyFindings();
  EmitAllKeyframes();
  return reports;
}

std::vector<LoopReport> SlamSystem::Impl::CloseLastLoop() {
  const KeyFrame* const last = map_.keyframe(last_keyframe_);
  if (last == nullptr || std::exchange(searched_at_end_, last->id) == last->id) return {};
  const SubmapId submap = last->submap;
  const auto prepare = [&] {
    if (options_.tracker.timing != FrameTimingMode::kIgnored) sensor_.CompensateAll(&map_);
  };
  std::vector<LoopReport> reports;
  // Keyframes that merge two worlds may close a loop, or merge a third one, as well.
  for (bool merged = true; merged;) {
    std::vector<KeyFrameId> own = map_.KeyFramesOf(submap);
    std::erase_if(own, [&](KeyFrameId id) { return id <= last_given_keyframe_; });
    const auto newest = std::span(own).last(std::min(kNewest, own.size()));
    const bool closes = [&] {
      const StageTimer timer(profile_, "loop search");
      return loop_closer_.InsertLast(map_, newest, prepare);
    }();
    std::ranges::move(loop_closer_.TakeRefused(), std::back_inserter(reports));
    if (!closes) break;
    worker_.Preempt(loop_closer_);
    std::vector<LoopReport> closed = loop_closer_.Finish(&map_);
    factor_adjuster_.Remember(map_, loop_closer_.TakeMovesByFactors());
    merged = std::ranges::any_of(
        closed, [](const LoopReport& report) { return report.accepted && report.merge; });
    std::ranges::move(closed, std::back_inserter(reports));
  }
  return reports;
}

BundleAdjustmentReport SlamSystem::Impl::AdjustAll() {
  HIGHWALL_REQUIRE(!options_.localize_only,
                   "SlamSystem::AdjustAll: SlamOptions::localize_only keeps the map as it is");
  const StageTimer timer(profile_, "adjustment of everything");
  BundleAdjustmentReport report;
  bool moved = false;
  WithTracker([&] {
    sensor_.CompensateAll(&map_);
    pending_.Attach(tracked_.frames(), &map_);
    for (const SubmapId root : map_.roots()) {
      worker_.Drop(map_, root);
      const BundleAdjustmentReport adjusted =
          AdjustBundle(map_, model_, map_.KeyFramesOf(root), {}, kGlobalAdjustment, {},
                       std::max(1, options_.threads));
      if (root == map_.Root(submap_)) report = adjusted;
      moved |= adjusted.usable;
    }
  });
  if (moved) {
    NotifyMoved();
    EmitAllKeyframes();
  }
  return report;
}

}  // namespace highwall
