#include "system/frame_trajectories.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "system/pose_smoother.h"

namespace highwall {
namespace {

MeasuredPose Measured(const PosedFrame& frame, const Map& map, const std::optional<Pose>& T_BC) {
  const Pose T_WC = frame.measured().T_WC(map);
  if (!T_BC || !frame.information) {
    return {frame.stamp, T_BC ? T_WC * T_BC->Inverse() : T_WC, frame.information};
  }
  return {frame.stamp, T_WC * T_BC->Inverse(), InformationOfBody(*frame.information, *T_BC)};
}

}  // namespace

void FrameTrajectories::Add(const PosedFrame& frame, SubmapId submap) {
  frames_.push_back(frame);
  ++number_in_[submap];
}

void FrameTrajectories::Forget(SubmapId submap, const Map& map) {
  number_in_.erase(submap);
  smoothed_.clear();
  std::erase_if(frames_, [&](const PosedFrame& t) { return !map.RootOf(t.pose.reference); });
}

void FrameTrajectories::Smooth(const Map& map, const std::optional<Pose>& T_BC) {
  std::map<SubmapId, std::vector<std::size_t>> by_root;
  smoothed_.clear();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    by_root[*map.RootOf(frames_[i].pose.reference)].push_back(i);
    smoothed_.push_back(frames_[i].pose);
  }
  for (const auto& [root, indices] : by_root) {
    const std::optional<Eigen::Vector3d>& gravity_W = map.gravity_W(root);
    // Not the body of an IMU that is not used, whose T_BC may be wrong.
    const bool has_readings = gravity_W && std::ranges::any_of(indices, [&](std::size_t i) {
                                return frames_[i].readings != nullptr;
                              });
    const std::optional<Pose> T_body_C = has_readings ? T_BC : std::nullopt;
    std::vector<MeasuredPose> measured;
    measured.reserve(indices.size());
    for (const std::size_t i : indices) {
      const bool follows = !measured.empty();
      measured.push_back(Measured(frames_[i], map, T_body_C));
      const auto& readings = frames_[i].readings;
      if (follows && readings && readings->before == measured.rbegin()[1].stamp) {
        measured.back().readings = readings;
      }
    }
    const std::vector<std::optional<Pose>> T_WB = SmoothPoses(measured, gravity_W);
    for (std::size_t k = 0; k < indices.size(); ++k) {
      if (!T_WB[k]) continue;
      AnchoredPose& pose = smoothed_[indices[k]];
      pose = AnchoredPose::At(map, pose.reference, T_body_C ? *T_WB[k] * *T_body_C : *T_WB[k]);
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
