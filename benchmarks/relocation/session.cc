#include "session.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace highwall::bench {

Session::Session(const RgbdSensor& sensor, const Trajectory& truth)
    : slam_(sensor, Deterministic({})) {
  for (const StampedPose& pose : truth) truth_[pose.stamp] = pose.pose;
  SlamCallbacks callbacks;
  callbacks.on_loop = [this](const LoopReport& report) { Judge(report); };
  slam_.SetCallbacks(std::move(callbacks));
}

Outcome Session::Track(const RgbdImage& image) {
  now_ = image.stamp;
  const FrameResult result = slam_.Track(image);
  Outcome outcome;
  outcome.pose = HasPose(result.state);
  outcome.T_WC = result.T_WC;
  outcome.submap = result.submap;
  if (result.reason) outcome.reason = ToString(*result.reason);
  outcome.matched = static_cast<double>(result.matched_points + result.matched_lines) /
                    std::max(1, result.points + result.lines);
  return outcome;
}

void Session::Finish() {
  slam_.Finish();
}

std::vector<Trajectory> Session::Trajectories() const {
  std::vector<Trajectory> trajectories;
  for (SubmapTrajectory& submap : slam_.submaps()) {
    trajectories.push_back(std::move(submap.frames));
  }
  return trajectories;
}

void Session::Judge(const LoopReport& report) {
  if (report.bundle) return;  // of a loop already counted
  if (!report.accepted) {
    refusals_.push_back(report.message);
    return;
  }
  const LoopEdge& edge = report.loop.edge;
  const KeyFrame* match = slam_.map().keyframe(edge.match);
  const KeyFrame* keyframe = slam_.map().keyframe(edge.keyframe);
  Meeting meeting{now_, report.merge, 0.0, 0.0};
  if (match != nullptr && keyframe != nullptr) {  // otherwise culled since then
    const Pose truth = truth_.at(match->frame.stamp).Inverse() * truth_.at(keyframe->frame.stamp);
    const Pose error = truth.Inverse() * edge.Z;
    meeting.metres = error.p().norm();
    meeting.degrees = error.Angle() * 180.0 / std::numbers::pi;
  }
  meetings_.push_back(meeting);
}

}  // namespace highwall::bench
