#include "system/frame_trajectories.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace highwall {

void FrameTrajectories::Add(const PosedFrame& frame, SubmapId submap) {
  frames_.push_back(frame);
  ++number_in_[submap];
}

void FrameTrajectories::Forget(SubmapId submap, const Map& map) {
  number_in_.erase(submap);
  std::erase_if(frames_, [&](const PosedFrame& t) { return !map.RootOf(t.pose.reference); });
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
  for (const PosedFrame& t : frames_) {
    const SubmapId root = *map.RootOf(t.pose.reference);
    const auto [found, is_new] =
        by_root.try_emplace(root, SubmapTrajectory{root, map.NumKeyFramesOf(root), {}});
    found->second.frames.push_back({t.stamp, t.pose.T_WC(map)});
  }
  std::vector<SubmapTrajectory> submaps;
  for (auto& [root, submap] : by_root) submaps.push_back(std::move(submap));
  std::ranges::stable_sort(submaps, std::greater(),
                           [](const SubmapTrajectory& s) { return s.frames.size(); });
  return submaps;
}

}  // namespace highwall
