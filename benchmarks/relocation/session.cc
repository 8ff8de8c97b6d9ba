#include "session.h"

#include <numbers>

namespace highwall::bench {

Session::Session(const RgbdSensor& sensor, const Trajectory& truth)
    : slam_(sensor, Deterministic({})) {
  for (const StampedPose& pose : truth) truth_[pose.stamp] = pose.pose;
  SlamCallbacks callbacks;
  callbacks.on_loop = [this](const LoopReport& report) { Judge(report, false); };
  slam_.SetCallbacks(std::move(callbacks));
}

Outcome Session::Track(const RgbdImage& image) {
  now_ = image.stamp;
  const FrameResult result = slam_.Track(image);
  const bool pose = HasPose(result.state);
  return {pose, result.T_WC, pose ? 0 : -1, pose ? "" : ToString(result.state)};
}

void Session::Finish() {
  slam_.Finish();
}

std::vector<Trajectory> Session::Trajectories() const {
  return {slam_.trajectory()};
}

void Session::Judge(const LoopReport& report, bool merge) {
  if (report.bundle) return;  // of one that was counted
  if (!report.accepted) {
    ++refused_;
    return;
  }
  const LoopEdge& edge = report.loop.edge;
  const KeyFrame* match = slam_.map().keyframe(edge.match);
  const KeyFrame* keyframe = slam_.map().keyframe(edge.keyframe);
  Meeting meeting{now_, merge, 0.0, 0.0};
  if (match != nullptr && keyframe != nullptr) {  // else culled since
    const Pose truth = truth_.at(match->frame.stamp).Inverse() * truth_.at(keyframe->frame.stamp);
    const Pose error = truth.Inverse() * edge.Z;
    meeting.metres = error.p().norm();
    meeting.degrees = error.Angle() * 180.0 / std::numbers::pi;
  }
  meetings_.push_back(meeting);
}

}  // namespace highwall::bench
