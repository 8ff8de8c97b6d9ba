#include <highwall/core/trajectory_error.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

#include "trajectory_alignment.h"

namespace highwall {
namespace {

// Relative tolerance of a path length to delta.
constexpr double kPathTolerance = 0.1;

using PosePair = std::pair<std::size_t, std::size_t>;

std::string Span(const Trajectory& trajectory) {
  if (trajectory.empty()) return "holds no pose";
  return "spans " + FormatStamp(trajectory.front().stamp) + " to " +
         FormatStamp(trajectory.back().stamp) + " s";
}

// Zero for fewer than two poses.
Stamp MedianInterval(const Trajectory& trajectory) {
  if (trajectory.size() < 2) return 0;
  std::vector<Stamp> intervals;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    intervals.push_back(trajectory[i].stamp - trajectory[i - 1].stamp);
  }
  return UpperMedian(std::move(intervals));
}

// Returns the sum of the intervals that are not longer than max_gap [s].
double CoveredTime(const Trajectory& trajectory, Stamp max_gap) {
  Stamp covered = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const Stamp interval = trajectory[i].stamp - trajectory[i - 1].stamp;
    if (interval <= max_gap) covered += interval;
  }
  return ToSeconds(covered);
}

// Computes the part of the result that does not depend on alignment or metric.
TrajectoryError MatchTrajectories(const Trajectory& reference, const Trajectory& estimate,
                                  double t_max_diff) {
  const Stamp tolerance = FromSeconds(t_max_diff);
  TrajectoryError result;
  for (const StampMatch& match : MatchByStamp(reference, estimate, tolerance)) {
    result.reference.push_back(reference[match.reference]);
    result.estimate.push_back(estimate[match.estimate]);
  }
  if (result.reference.empty()) {
    throw InvalidArgument("no stamps match within " + FormatStamp(tolerance) +
                          " s: the reference " + Span(reference) + ", the estimate " +
                          Span(estimate));
  }
  result.max_gap =
      std::max({3 * MedianInterval(reference), 3 * MedianInterval(estimate), tolerance});
  const double seen = CoveredTime(reference, result.max_gap);
  // The ends of a matched interval may lie outside of the reference by the tolerance.
  if (seen > 0.0) {
    result.time_covered = std::min(1.0, CoveredTime(result.estimate, result.max_gap) / seen);
  }
  return result;
}

internal::PositionAlignment FindAlignment(const TrajectoryError& matched,
                                          TrajectoryAlignment alignment) {
  switch (alignment) {
    case TrajectoryAlignment::kNone:
      break;
    case TrajectoryAlignment::kSe3:
    case TrajectoryAlignment::kSim3:
      return internal::AlignPoses(matched.reference, matched.estimate,
                                  alignment == TrajectoryAlignment::kSim3);
    case TrajectoryAlignment::kScale:
      return {.S_AB = {internal::AlignPoses(matched.reference, matched.estimate, true).S_AB.scale,
                       Pose()}};
    case TrajectoryAlignment::kOrigin:
      return {
          .S_AB = {1.0, matched.reference.front().pose * matched.estimate.front().pose.Inverse()}};
  }
  return {};
}

void Align(TrajectoryAlignment alignment, TrajectoryError* matched) {
  const internal::PositionAlignment found = FindAlignment(*matched, alignment);
  const Similarity& similarity = found.S_AB;
  matched->scale = similarity.scale;
  matched->open_rotation = found.open;
  for (StampedPose& stamped : matched->estimate) stamped.pose = similarity * stamped.pose;
}

double Measure(const Pose& error, PoseRelation relation) {
  switch (relation) {
    case PoseRelation::kTranslation:
      break;
    case PoseRelation::kAngleDegrees:
      return error.Angle() * 180.0 / M_PI;
    case PoseRelation::kFull:
      return (error.Matrix() - Eigen::Matrix4d::Identity()).norm();
  }
  return error.p().norm();
}

// Path length from the first pose to each pose [m].
std::vector<double> PathLengths(const Trajectory& trajectory) {
  std::vector<double> lengths(trajectory.size(), 0.0);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    lengths[i] = lengths[i - 1] + (trajectory[i].pose.p() - trajectory[i - 1].pose.p()).norm();
  }
  return lengths;
}

std::vector<PosePair> PairsByFrames(std::size_t poses, std::size_t delta, bool all_pairs) {
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i + delta < poses; i += all_pairs ? 1 : delta) {
    pairs.emplace_back(i, i + delta);
  }
  return pairs;
}

std::vector<PosePair> ConsecutivePairsByPath(const Trajectory& trajectory, double delta) {
  std::vector<std::size_t> ends;
  double path = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    path += (trajectory[i].pose.p() - trajectory[i - 1].pose.p()).norm();
    if (path < delta) continue;
    ends.push_back(i);
    path = 0.0;
  }
  std::vector<PosePair> pairs;
  // As in evo, the first stretch is skipped: the first pair begins at its end.
  for (std::size_t k = 1; k < ends.size(); ++k) pairs.emplace_back(ends[k - 1], ends[k]);
  return pairs;
}

std::vector<PosePair> AllPairsByPath(const Trajectory& trajectory, double delta) {
  const std::vector<double> lengths = PathLengths(trajectory);
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i + 1 < lengths.size(); ++i) {
    const auto first = lengths.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    const auto deviation = [&](auto at) { return std::abs(*at - lengths[i] - delta); };
    auto end = std::lower_bound(first, lengths.end(), lengths[i] + delta);
    if (end != first && (end == lengths.end() || deviation(end - 1) <= deviation(end))) {
      // The first of several stationary poses at that length.
      end = std::lower_bound(first, lengths.end(), *(end - 1));
    }
    if (deviation(end) > kPathTolerance * delta) continue;
    pairs.emplace_back(i, static_cast<std::size_t>(end - lengths.begin()));
  }
  return pairs;
}

std::vector<PosePair> FindPairs(const Trajectory& estimate,
                                const RelativePoseErrorOptions& options) {
  if (options.delta_unit == DeltaUnit::kFrames) {
    return PairsByFrames(estimate.size(), static_cast<std::size_t>(options.delta),
                         options.all_pairs);
  }
  return options.all_pairs ? AllPairsByPath(estimate, options.delta)
                           : ConsecutivePairsByPath(estimate, options.delta);
}

void RequireTolerance(double t_max_diff) {
  HIGHWALL_REQUIRE(t_max_diff >= 0.0 && t_max_diff <= 1e6,
                   "t_max_diff must lie in [0, 1e6] s, got " + FixedText(t_max_diff));
}

}  // namespace

void AbsolutePoseErrorOptions::Validate() const {
  RequireTolerance(t_max_diff);
}

void RelativePoseErrorOptions::Validate() const {
  RequireTolerance(t_max_diff);
  HIGHWALL_REQUIRE(delta > 0.0 && delta <= 1e9,
                   "delta must lie in (0, 1e9], got " + FixedText(delta));
  HIGHWALL_REQUIRE(delta_unit != DeltaUnit::kFrames || delta == std::floor(delta),
                   "delta must be a whole number of frames, got " + FixedText(delta));
}

ErrorStatistics ComputeStatistics(const std::vector<double>& errors) {
  HIGHWALL_REQUIRE(!errors.empty(), "statistics need at least one error");
  const auto n = static_cast<double>(errors.size());
  std::vector<double> sorted = errors;
  std::sort(sorted.begin(), sorted.end());
  ErrorStatistics s;
  s.min = sorted.front();
  s.max = sorted.back();
  s.median = 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
  s.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / n;
  s.sse = std::inner_product(sorted.begin(), sorted.end(), sorted.begin(), 0.0);
  s.rmse = std::sqrt(s.sse / n);
  double deviation = 0.0;
  for (const double error : sorted) deviation += (error - s.mean) * (error - s.mean);
  s.std = std::sqrt(deviation / n);
  return s;
}

Pose Similarity::operator*(const Pose& T_BC) const {
  return T_AB * Pose(T_BC.q(), scale * T_BC.p());
}

TrajectoryError AbsolutePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const AbsolutePoseErrorOptions& options) {
  options.Validate();
  TrajectoryError result = MatchTrajectories(reference, estimate, options.t_max_diff);
  Align(options.alignment, &result);
  for (std::size_t i = 0; i < result.reference.size(); ++i) {
    const Pose E = result.reference[i].pose.Inverse() * result.estimate[i].pose;
    result.errors.push_back(Measure(E, options.relation));
    result.indices.push_back(i);
  }
  result.statistics = ComputeStatistics(result.errors);
  return result;
}

TrajectoryError RelativePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const RelativePoseErrorOptions& options) {
  options.Validate();
  TrajectoryError result = MatchTrajectories(reference, estimate, options.t_max_diff);
  Align(options.alignment, &result);
  const Trajectory& Q = result.reference;
  const Trajectory& P = result.estimate;
  for (const auto& [i, j] : FindPairs(P, options)) {
    const Pose dQ = Q[i].pose.Inverse() * Q[j].pose;
    const Pose dP = P[i].pose.Inverse() * P[j].pose;
    result.errors.push_back(Measure(dQ.Inverse() * dP, options.relation));
    result.indices.push_back(j);
  }
  if (result.errors.empty()) {
    throw InvalidArgument("no two matched poses are " + FixedText(options.delta) +
                          (options.delta_unit == DeltaUnit::kFrames ? " frames" : " m") +
                          " apart: " + std::to_string(P.size()) + " poses match, along a path of " +
                          FixedText(PathLengths(P).back()) + " m; choose a smaller delta");
  }
  result.statistics = ComputeStatistics(result.errors);
  return result;
}

}  // namespace highwall
