#include "inertial/imu_monitor.h"

#include <algorithm>

namespace highwall {
namespace {

constexpr double kPoseStep = 0.03;  // [s] between poses
// [ns] With it a part lasts longer than steps between poses that follow each other (ImuAlignment).
constexpr Stamp kAround = 80'000'000;
constexpr double kCheckInterval = 1.0, kEarlyInterval = 0.5;  // [s] once confirmed, and before

}  // namespace

void ImuMonitor::Add(Stamp stamp, const Pose& T_WC) {
  constexpr double kRounding = 1e-3;  // [s]
  if (!poses_.empty() && ToSeconds(stamp - poses_.back().stamp) < kPoseStep - kRounding) return;
  poses_.push_back({stamp, T_WC});
  const Stamp oldest = stamp - FromSeconds(kMonitored);
  std::erase_if(poses_, [oldest](const StampedPose& pose) { return pose.stamp < oldest; });
  std::erase_if(contradicted_, [oldest](const auto& event) { return event.second < oldest; });
}

void ImuMonitor::LeaveOut(Stamp from, Stamp to) {
  // The predictions for the images after contradicted readings are too uncertain to be
  // contradicted.
  constexpr Stamp kOneEvent = 300'000'000;  // [ns]
  if (!contradicted_.empty() && from - contradicted_.back().second <= kOneEvent) {
    contradicted_.back().second = to;
  } else {
    contradicted_.emplace_back(from, to);
  }
}

Trajectory ImuMonitor::Trusted() const {
  constexpr Stamp kShock = 400'000'000;  // [ns]
  constexpr std::size_t kOneIn = 5;      // the most that are left out
  Trajectory trusted = poses_;
  for (const auto& [from, to] : contradicted_) {
    if (to - from > kShock) continue;
    std::erase_if(trusted,
                  [&, first = from - kAround, last = to + kAround](const StampedPose& pose) {
                    return first < pose.stamp && pose.stamp < last;
                  });
  }
  return kOneIn * (poses_.size() - trusted.size()) <= poses_.size() ? trusted : poses_;
}

void ImuMonitor::MoveMap(const Pose& T_new_old) {
  for (StampedPose& pose : poses_) pose.pose = T_new_old * pose.pose;
}

void ImuMonitor::Clear() {
  poses_.clear();
  contradicted_.clear();
}

std::optional<ImuJudgement> ImuMonitor::Check(Stamp image, const ImuBuffer& readings,
                                              const ImuCalibration& calibration,
                                              bool is_confirmed) {
  if (poses_.size() < 2 || readings.size() < 2) return std::nullopt;
  const double interval = is_confirmed ? kCheckInterval : kEarlyInterval;
  if (last_check_ && ToSeconds(image - *last_check_) < interval) return std::nullopt;
  last_check_ = image;
  // The clocks may be apart, or of different rates.
  const Stamp from = poses_.front().stamp - FromSeconds(1.0 + kMonitored);
  const Stamp begin = std::max(readings.oldest(), std::min(from, readings.newest() - 1));
  const auto interval_of = readings.Between(begin, readings.newest());
  if (!interval_of) return std::nullopt;
  const auto judge = [&](const Trajectory& poses) {
    return JudgeImu(poses, interval_of->samples, calibration, max_step_);
  };
  const Trajectory trusted = Trusted();
  ImuJudgement judgement = judge(trusted);
  if (trusted.size() == poses_.size() || judgement.agreement != ImuAgreement::kUndecided) {
    return judgement;
  }
  // What is left says nothing: a single fault that explains what was left out was no shock. Some
  // scale of the depth explains a shock as well.
  ImuJudgement of_all = judge(poses_);
  const bool is_explained = of_all.finding &&
                            of_all.finding->fault != SensorFault::kImuInconsistent &&
                            of_all.finding->fault != SensorFault::kDepthScale;
  return is_explained ? of_all : judgement;
}

}  // namespace highwall
