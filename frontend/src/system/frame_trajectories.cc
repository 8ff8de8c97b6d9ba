#include "system/frame_trajectories.h"

#include <algorithm>
#include <functional>
#include <utility>

#include <highwall/core/so3.h>

#include "features/memory_bytes.h"
#include "system/pose_smoother.h"

namespace highwall {
namespace {

// Frames whose motion predicts the newest one: a few seconds.
constexpr std::size_t kLearnedFrom = 200;
constexpr std::size_t kMostSearched = 400;  // for frames of the same world

MeasuredPose Measured(const PosedFrame& frame, const Map& map, const std::optional<Pose>& T_BC) {
  const AnchoredPose& by_image = frame.measured();
  MeasuredPose pose{.stamp = frame.measured_at(),
                    .T_WB = by_image.T_WC(map),
                    .information = frame.information,
                    .reference = by_image.reference};
  if (!T_BC) return pose;
  pose.T_WB = pose.T_WB * T_BC->Inverse();
  if (pose.information) pose.information = InformationOfBody(*pose.information, *T_BC);
  return pose;
}

// Returns the poses of the frames at `indices` by time: what images state, each at the time of its
// image, and where the stamp of a late image is, a pose of which nothing is stated.
std::vector<MeasuredPose> ByTime(const std::vector<PosedFrame>& frames,
                                 const std::vector<std::size_t>& indices, const Map& map,
                                 const std::optional<Pose>& T_BC) {
  std::vector<MeasuredPose> poses;
  poses.reserve(indices.size());
  for (const std::size_t i : indices) {
    const PosedFrame& frame = frames[i];
    const bool follows = !poses.empty();
    poses.push_back(Measured(frame, map, T_BC));
    if (follows && frame.readings && frame.readings->before == poses.rbegin()[1].stamp) {
      poses.back().readings = frame.readings;
    }
    if (frame.delay > 0) {
      const Pose T_WC = frame.pose.T_WC(map);
      poses.push_back(
          {frame.stamp, T_BC ? T_WC * T_BC->Inverse() : T_WC, ImageInformation::Zero()});
    }
  }
  // At the time of a late image another frame, which repeats one, may have an extrapolated pose.
  std::ranges::stable_sort(poses, {}, [](const MeasuredPose& pose) {
    return std::pair(pose.stamp, pose.information && pose.information->isZero(0.0F));
  });
  const auto same_time = [](const MeasuredPose& a, const MeasuredPose& b) {
    return a.stamp == b.stamp;
  };
  poses.erase(std::unique(poses.begin(), poses.end(), same_time), poses.end());
  return poses;
}

// Rotates v_WB by R, and its covariance.
BodyVelocity Rotated(const BodyVelocity& velocity, const Eigen::Matrix3d& R) {
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Identity();
  J.topLeftCorner<3, 3>() = R;
  return {R * velocity.v_WB, velocity.omega_B, J * velocity.covariance * J.transpose()};
}

// Returns the velocity of the camera on a body, along the axes of the camera.
BodyVelocity OfCamera(const SmoothedPose& body, const Pose& T_BC) {
  const Eigen::Matrix3d R_CB = T_BC.R().transpose();
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.topLeftCorner<3, 3>() = R_CB * body.T_WB.R().transpose();
  J.topRightCorner<3, 3>() = -R_CB * so3::Hat(T_BC.p());
  J.bottomRightCorner<3, 3>() = R_CB;
  Eigen::Matrix<double, 6, 1> of_B, of_C;
  of_B << body.velocity->v_WB, body.velocity->omega_B;
  of_C = J * of_B;
  return {of_C.head<3>(), of_C.tail<3>(), J * body.velocity->covariance * J.transpose()};
}

}  // namespace

void FrameTrajectories::Add(const PosedFrame& frame, SubmapId submap) {
  frames_.push_back(frame);
  ++number_in_[submap];
}

void FrameTrajectories::Insert(const std::vector<PosedFrame>& found, const Map& map) {
  if (!found.empty()) smoothed_.clear();
  const auto tracked = static_cast<std::ptrdiff_t>(frames_.size());
  for (const PosedFrame& frame : found) {
    const KeyFrameId active = map.ActiveKeyFrameOf(frame.pose.reference)->first;
    Add(frame, map.keyframe(active)->submap);
  }
  std::ranges::inplace_merge(frames_, frames_.begin() + tracked, {}, &PosedFrame::stamp);
}

void FrameTrajectories::Forget(SubmapId submap, const Map& map) {
  number_in_.erase(submap);
  smoothed_.clear();
  std::erase_if(frames_, [&](const PosedFrame& t) { return !map.RootOf(t.pose.reference); });
}

std::optional<Pose> FrameTrajectories::PredictNewest(const Map& map) const {
  const SubmapId root = *map.RootOf(frames_.back().pose.reference);
  std::vector<std::size_t> latest;
  const std::size_t oldest = frames_.size() - std::min(frames_.size(), kMostSearched);
  for (std::size_t i = frames_.size(); i-- > oldest && latest.size() < kLearnedFrom;) {
    if (map.RootOf(frames_[i].pose.reference) == root) latest.push_back(i);
  }
  std::ranges::reverse(latest);
  return PredictLastPose(ByTime(frames_, latest, map, std::nullopt));
}

void FrameTrajectories::Smooth(const Map& map, const std::optional<Pose>& T_BC) {
  std::map<SubmapId, std::vector<std::size_t>> by_root;
  smoothed_.clear();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    by_root[*map.RootOf(frames_[i].pose.reference)].push_back(i);
    smoothed_.push_back({frames_[i].pose});
  }
  for (const auto& [root, indices] : by_root) {
    const std::optional<Eigen::Vector3d>& gravity_W = map.gravity_W(root);
    // Not the body of an IMU that is not used, whose T_BC may be wrong.
    const bool has_readings = gravity_W && std::ranges::any_of(indices, [&](std::size_t i) {
                                return frames_[i].readings != nullptr;
                              });
    const std::optional<Pose> T_body_C = has_readings ? T_BC : std::nullopt;
    const std::vector<MeasuredPose> measured = ByTime(frames_, indices, map, T_body_C);
    const std::vector<std::optional<SmoothedPose>> bodies = SmoothPoses(measured, gravity_W);
    for (const std::size_t i : indices) {
      const auto at =
          std::ranges::lower_bound(measured, frames_[i].stamp, {}, &MeasuredPose::stamp);
      const std::optional<SmoothedPose>& body =
          bodies[static_cast<std::size_t>(at - measured.begin())];
      if (!body) continue;
      Smoothed& frame = smoothed_[i];
      frame.pose = AnchoredPose::At(map, frame.pose.reference,
                                    T_body_C ? body->T_WB * *T_body_C : body->T_WB);
      if (body->velocity) frame.of_C = OfCamera(*body, T_body_C.value_or(Pose()));
    }
  }
}

std::size_t FrameTrajectories::MemoryBytes() const {
  std::size_t bytes = BytesOf(frames_) + BytesOf(smoothed_);
  for (const PosedFrame& frame : frames_) {
    if (frame.readings) bytes += sizeof(ReadingsBetween) + BytesOf(frame.readings->samples);
  }
  return bytes;
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
    const Smoothed& frame = i < smoothed_.size() ? smoothed_[i] : Smoothed{frames_[i].pose};
    const SubmapId root = *map.RootOf(frame.pose.reference);
    const auto [found, is_new] =
        by_root.try_emplace(root, SubmapTrajectory{root, map.NumKeyFramesOf(root), {}, {}});
    const Pose T_WC = frame.pose.T_WC(map);
    found->second.frames.push_back({frames_[i].stamp, T_WC});
    if (!frame.of_C) continue;
    const BodyVelocity in_W = Rotated(*frame.of_C, T_WC.R());
    found->second.velocities.push_back(
        {frames_[i].stamp, in_W.v_WB, in_W.omega_B, in_W.covariance});
  }
  std::vector<SubmapTrajectory> submaps;
  for (auto& [root, submap] : by_root) submaps.push_back(std::move(submap));
  std::ranges::stable_sort(submaps, std::greater(),
                           [](const SubmapTrajectory& s) { return s.frames.size(); });
  return submaps;
}

}  // namespace highwall
