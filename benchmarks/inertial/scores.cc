#include "scores.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/imu_preintegration.h>

#include "scenes.h"

namespace highwall::bench {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

double PathLength(const Trajectory& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].pose.p() - trajectory[i - 1].pose.p()).norm();
  }
  return length;
}

// Returns the angle between both vertical directions.
double TiltDegrees(const Pose& estimate, const Pose& truth) {
  const Eigen::Vector3d up = estimate.q().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d true_up = truth.q().conjugate() * Eigen::Vector3d::UnitZ();
  return kDegrees * std::atan2(up.cross(true_up).norm(), up.dot(true_up));
}

double Rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Returns the relative errors over a second, from every frame on; empty if too few are tracked.
std::vector<double> SecondErrors(const Trajectory& truth, const Trajectory& estimate, double fps) {
  try {
    return RelativePoseError(truth, estimate, {.delta = std::round(fps), .all_pairs = true}).errors;
  } catch (const InvalidArgument&) {
    return {};
  }
}

}  // namespace

Judge::Judge(const Sequence& sequence, double time_offset)
    : sequence_(sequence),
      time_offset_(time_offset),
      truth_(TrueTrajectory(*sequence.simulation)) {}

double Judge::Seconds(Stamp stamp) const {
  return ToSeconds(stamp - truth_.front().stamp);
}

void Judge::Watch(const FrameResult& result) {
  if (result.inertial && result.inertial->T_gravity) {
    for (StampedPose& pose : levelled_) pose.pose = *result.inertial->T_gravity * pose.pose;
  }
  if (HasPose(result.state)) {
    causal_.push_back({result.stamp, result.T_WC});
    levelled_.push_back(causal_.back());
  }
  if (!result.inertial || !result.inertial->estimate) return;
  const InertialEstimate& estimate = *result.inertial->estimate;
  const simulate::TrueState truth = sequence_.simulation->StateAt(result.stamp);
  bias_sigmas_ = (estimate.bias - truth.bias)
                     .cwiseQuotient(estimate.covariance.diagonal().tail<6>().cwiseSqrt());
  if (levelled_.empty()) return;
  const StampedPose& first = levelled_.front();
  const Pose T_WV = first.pose * sequence_.simulation->T_WC(first.stamp).Inverse();
  normalized_.push_back(
      Normalize(estimate, result.inertial->gravity_sigma, truth.state, truth.bias, T_WV));
}

Scores Judge::Score(const apps::SlamRun& run) const {
  Scores scores;
  ScoreTrajectory(run, &scores);
  ScoreSpans(run, &scores);
  ScoreInertial(run, &scores);
  return scores;
}

void Judge::ScoreTrajectory(const apps::SlamRun& run, Scores* scores) const {
  Scores& s = *scores;
  s["lost_frames"] = static_cast<double>(run.lost.size() + run.skipped);
  s["coverage"] =
      static_cast<double>(run.largest.trajectory.size()) / static_cast<double>(truth_.size());
  s["tracking_ms"] = run.times.tracking.median;
  s["seconds"] = run.seconds;
  try {
    s["ape_rmse_m"] = AbsolutePoseError(truth_, run.largest.trajectory).statistics.rmse;
    s["ape_percent"] = 100.0 * s["ape_rmse_m"] / PathLength(truth_);
  } catch (const InvalidArgument&) {  // too few poses
  }
  const auto errors =
      SecondErrors(truth_, run.largest.trajectory, sequence_.simulation->options().fps);
  if (!errors.empty()) s["rpe_1s_rmse_m"] = Rms(errors);
}

void Judge::ScoreSpans(const apps::SlamRun& run, Scores* scores) const {
  std::map<std::string, std::vector<double>> errors, drifts;
  for (const MarkedSpan& span : sequence_.spans) {
    const Stamp begin = truth_.front().stamp + FromSeconds(span.begin);
    const Stamp end = truth_.front().stamp + FromSeconds(span.end);
    const auto part =
        SecondErrors(Between(truth_, begin, end), Between(run.largest.trajectory, begin, end),
                     sequence_.simulation->options().fps);
    errors[span.name].insert(errors[span.name].end(), part.begin(), part.end());

    // From its first frame to its last, with the poses at the time of tracking.
    const Trajectory causal = Between(levelled_, begin, end);
    const Trajectory truth = Between(truth_, begin, end);
    (*scores)[span.name + "_lost_frames"] +=
        static_cast<double>(truth.size()) - static_cast<double>(causal.size());
    if (causal.size() < 2 || causal.back().stamp != truth.back().stamp) continue;
    const Pose motion = causal.front().pose.Inverse() * causal.back().pose;
    const Pose true_motion = sequence_.simulation->T_WC(causal.front().stamp).Inverse() *
                             sequence_.simulation->T_WC(causal.back().stamp);
    drifts[span.name].push_back(100.0 * (motion.p() - true_motion.p()).norm() / PathLength(truth));
  }
  for (const MarkedSpan& span : sequence_.spans) {
    if (span.name != kBlackoutSpan) continue;
    if (const auto drift = ExactStart(span)) (*scores)["blackout_exact_start_percent"] = *drift;
  }
  for (const auto& [name, values] : errors) {
    if (!values.empty()) (*scores)[name + "_rpe_1s_rmse_m"] = Rms(values);
  }
  for (const auto& [name, values] : drifts) {
    (*scores)[name + "_drift_percent"] = *std::max_element(values.begin(), values.end());
  }
}

std::optional<double> Judge::ExactStart(const MarkedSpan& span) const {
  const simulate::Simulation& simulation = *sequence_.simulation;
  const Trajectory truth = Between(truth_, truth_.front().stamp + FromSeconds(span.begin),
                                   truth_.front().stamp + FromSeconds(span.end));
  if (truth.size() < 2) return std::nullopt;  // beyond the end of the sequence
  ImuBuffer buffer({.horizon = 1e6});
  for (ImuSample sample : simulation.ImuSamples()) {
    sample.stamp -= FromSeconds(simulation.options().imu.time_offset);
    buffer.Add(sample);
  }
  const auto interval = buffer.Between(truth.front().stamp, truth.back().stamp);
  if (!interval) throw IoError(span.name, "has no readings");
  const simulate::TrueState start = simulation.StateAt(truth.front().stamp);
  const ImuState end =
      ImuPreintegration(interval->samples, start.bias)
          .Predict(start.state, start.bias, -kStandardGravity * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d p = simulation.StateAt(truth.back().stamp).state.T_WB.p();
  return 100.0 * (end.T_WB.p() - p).norm() / PathLength(truth);
}

void Judge::ScoreInertial(const apps::SlamRun& run, Scores* scores) const {
  if (!run.inertial) return;
  Scores& s = *scores;
  const apps::InertialSummary& inertial = *run.inertial;
  s["dead_reckoned_frames"] = static_cast<double>(inertial.dead_reckoned);
  s["restarts"] = static_cast<double>(inertial.restarts);
  s["contradicted_intervals"] = static_cast<double>(inertial.contradicted);
  s["saturated_intervals"] = static_cast<double>(inertial.saturated);
  s["mean_weight"] = inertial.mean_weight;
  s["reduced_share"] = inertial.reduced_share;
  s["innovation_chi2_per_dof"] = inertial.mean_innovation;
  if (inertial.tight.count > 0) {
    s["tight_update_ms"] = inertial.tight.median;
    s["tight_update_p95_ms"] = inertial.tight.p95;
    s["refused_tight_updates"] = static_cast<double>(inertial.refused_updates);
  }
  if (!inertial.initialized) return;
  s["initialized_s"] = Seconds(*inertial.initialized);
  s["time_offset_error_ms"] = 1e3 * std::abs(inertial.last.time_offset - time_offset_);
  s["time_offset_sigma_ms"] = 1e3 * inertial.last.time_offset_sigma;
  // A tilt during the first seconds affects the map, and is visible in later poses.
  constexpr double kSettled = 5.0;  // [s]
  for (const StampedPose& pose : causal_) {
    if (Seconds(pose.stamp) < kSettled) continue;
    const double tilt = TiltDegrees(pose.pose, sequence_.simulation->T_WC(pose.stamp));
    s.emplace("tilt_at_5s_deg", tilt);
    s["tilt_max_after_5s_deg"] = std::max(s["tilt_max_after_5s_deg"], tilt);
  }
  if (bias_sigmas_) s["bias_error_sigmas"] = bias_sigmas_->cwiseAbs().maxCoeff();
  if (normalized_.empty()) return;
  double chi2 = 0.0;
  for (const NormalizedErrors& errors : normalized_) chi2 += errors.bias;
  s["bias_chi2_per_dof"] = chi2 / static_cast<double>(normalized_.size());
  s["end_tilt_chi2_per_dof"] = normalized_.back().tilt;
  s["end_velocity_chi2_per_dof"] = normalized_.back().velocity;
  s["end_pose_chi2_per_dof"] = normalized_.back().pose;
  s["end_bias_chi2_per_dof"] = normalized_.back().bias;
}

}  // namespace highwall::bench
