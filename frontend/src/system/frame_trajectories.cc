#include "system/frame_trajectories.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "system/pose_smoother.h"

namespace highwall {

void FrameTrajectories::Add(const PosedFrame& frame, SubmapId submap) {
  frames_.push_back(frame);
  ++number_in_[submap];
}

void FrameTrajectories::Forget(SubmapId submap, const Map& map) {
  number_in_.erase(submap);
  smoothed_.clear();
  std::erase_if(frames_, [&](const PosedFrame& t) { return !map.RootOf(t.pose.reference); });
}

void FrameTrajectories::Smooth(const Map& map) {
  std::map<SubmapId, std::vector<std::size_t>> by_root;
  smoothed_.clear();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    by_root[*map.RootOf(frames_[i].pose.reference)].push_back(i);
    smoothed_.push_back(frames_[i].pose);
  }
  for (const auto& [root, indices] : by_root) {
    std::vector<MeasuredPose> measured;
    measured.reserve(indices.size());
    for (const std::size_t i : indices) {
      measured.push_back({frames_[i].stamp, frames_[i].pose.T_WC(map), frames_[i].information});
    }
    const std::vector<Pose> T_WC = SmoothPoses(measured);
    for (std::size_t k = 0; k < indices.size(); ++k) {
      AnchoredPose& pose = smoothed_[indices[k]];
      pose = AnchoredPose::At(map, pose.reference, T_WC[k]);
    }
  }
}

std::optional<SubmapId> FrameTrajectories::LargestWorld(const Map& map) const {
  std::map<SubmapId, std::size_t> by_root;
  for (const auto& [submap, number] : number_in_) by_root[map.Root(submap)] += number;
  const auto largest =
      std::ranges::max_element(by_root, {}, [](const auto& of) { return of.second; });
  return largest != by_root.end() ? std::optional(largest->first) : std::nullopt;
}

std::vector<SubmapTrajectory> FrameTrajectories::ByWorld(const Map& map) const {
  std::map<SubmapId, SubmapTrajectory> by_root;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const AnchoredPose& pose = i < smoothed_.size() ? smoothed_[i] : frames_[i].pose;
    const SubmapId root = *map.RootOf(pose.reference);
    const auto [found, is_new] =
        by_root.try_emplace(root, SubmapTrajectory{root, map.NumKeyFramesOf(root), {}});
    found->second.frames.push_back({frames_[i].stamp, pose.T_WC(map)});
  }
  std::vector<SubmapTrajectory> submaps;
  for (auto& [root, submap] : by_root) submaps.push_back(std::move(submap));
  std::ranges::stable_sort(submaps, std::greater(),
                           [](const SubmapTrajectory& s) { return s.frames.size(); });
  return submaps;
}

}  // namespace highwall
