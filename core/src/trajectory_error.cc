#include <highwall/core/trajectory_error.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include <Eigen/SVD>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>

namespace highwall {
namespace {

// A path counts as delta metres long within this share of delta.
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

// Sum of the intervals that are no longer than max_gap [s].
double CoveredTime(const Trajectory& trajectory, Stamp max_gap) {
  Stamp covered = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const Stamp interval = trajectory[i].stamp - trajectory[i - 1].stamp;
    if (interval <= max_gap) covered += interval;
  }
  return ToSeconds(covered);
}

// The part of the result that does not depend on alignment or metric.
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
  // The ends of a matched interval may stick out of the reference by the tolerance.
  if (seen > 0.0) {
    result.time_covered = std::min(1.0, CoveredTime(result.estimate, result.max_gap) / seen);
  }
  return result;
}

Eigen::Matrix3Xd Positions(const Trajectory& trajectory) {
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(trajectory.size()));
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    positions.col(i) = trajectory[static_cast<std::size_t>(i)].pose.p();
  }
  return positions;
}

Similarity FindAlignment(const TrajectoryError& matched, TrajectoryAlignment alignment) {
  switch (alignment) {
    case TrajectoryAlignment::kNone:
      break;
    case TrajectoryAlignment::kSe3:
    case TrajectoryAlignment::kSim3:
      return AlignUmeyama(Positions(matched.reference), Positions(matched.estimate),
                          alignment == TrajectoryAlignment::kSim3);
    case TrajectoryAlignment::kScale:
      return {AlignUmeyama(Positions(matched.reference), Positions(matched.estimate), true).scale,
              Pose()};
    case TrajectoryAlignment::kOrigin:
      return {1.0, matched.reference.front().pose * matched.estimate.front().pose.Inverse()};
  }
  return {};
}

void Align(TrajectoryAlignment alignment, TrajectoryError* matched) {
  const Similarity similarity = FindAlignment(*matched, alignment);
  matched->scale = similarity.scale;
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
  // As in evo, the first stretch is only the run-up: the first pair begins at its end.
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
      // The first of the poses that stood still there.
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
                   "t_max_diff must lie in [0, 1e6] s, got " + std::to_string(t_max_diff));
}

}  // namespace

void AbsolutePoseErrorOptions::Validate() const {
  RequireTolerance(t_max_diff);
}

void RelativePoseErrorOptions::Validate() const {
  RequireTolerance(t_max_diff);
  HIGHWALL_REQUIRE(delta > 0.0 && delta <= 1e9,
                   "delta must lie in (0, 1e9], got " + std::to_string(delta));
  HIGHWALL_REQUIRE(delta_unit != DeltaUnit::kFrames || delta == std::floor(delta),
                   "delta must be a whole number of frames, got " + std::to_string(delta));
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

Similarity AlignUmeyama(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, bool with_scale) {
  HIGHWALL_REQUIRE(a.cols() == b.cols(), "alignment needs as many points on either side");
  HIGHWALL_REQUIRE(a.allFinite() && b.allFinite(), "alignment needs finite points");
  if (a.cols() < 3) {
    throw InvalidArgument("alignment by se3 or sim3 needs three matched poses, found " +
                          std::to_string(a.cols()) + ": align by origin or none");
  }
  const auto n = static_cast<double>(a.cols());
  const Eigen::Vector3d mean_a = a.rowwise().mean();  // Eq. 35
  const Eigen::Vector3d mean_b = b.rowwise().mean();  // Eq. 34
  const Eigen::Matrix3Xd centred_b = b.colwise() - mean_b;
  const double variance_b = centred_b.squaredNorm() / n;                                  // Eq. 36
  const Eigen::Matrix3d covariance = (a.colwise() - mean_a) * centred_b.transpose() / n;  // Eq. 38
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d d = svd.singularValues();
  if (!(d(1) > 1e-12 * d(0))) {
    throw InvalidArgument(
        "alignment by se3 or sim3 is not determined, since all matched positions lie on one line "
        "or in one point: align by origin or none");
  }
  Eigen::Vector3d s = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) s(2) = -1.0;  // Eq. 39, 43
  const Eigen::Matrix3d R = svd.matrixU() * s.asDiagonal() * svd.matrixV().transpose();  // Eq. 40
  const double scale = with_scale ? d.dot(s) / variance_b : 1.0;                         // Eq. 42
  return {scale, Pose(Eigen::Quaterniond(R), mean_a - scale * R * mean_b)};              // Eq. 41
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
    throw InvalidArgument("no two matched poses are " + std::to_string(options.delta) +
                          (options.delta_unit == DeltaUnit::kFrames ? " frames" : " m") +
                          " apart: " + std::to_string(P.size()) + " poses match, along a path of " +
                          std::to_string(PathLengths(P).back()) + " m; choose a smaller delta");
  }
  result.statistics = ComputeStatistics(result.errors);
  return result;
}

}  // namespace highwall
