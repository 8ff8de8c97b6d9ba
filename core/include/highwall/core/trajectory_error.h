#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>

// Absolute and relative pose error (APE, RPE) of an estimated trajectory. The figures equal those
// of evo (github.com/MichaelGrupp/evo). Source: Sturm et al., "A benchmark for the evaluation of
// RGB-D SLAM systems", IROS 2012, section IV.
//
// ExplainError() decomposes the absolute error: the parts that a time shift, a scale or a lever arm
// would remove, and how fast the remaining error varies (docs/evaluation.md).

namespace [[gnu::visibility("default")]] highwall {

// Alignment of the estimate to the reference before they are compared.
enum class TrajectoryAlignment {
  kNone,
  kSe3,     // rigid, least squares over all matched positions
  kSim3,    // the same with scale
  kScale,   // only the scale of kSim3: positions are multiplied, not moved
  kOrigin,  // aligns the first matched poses
};

// Number derived from an error transform E = (R, t).
enum class PoseRelation {
  kTranslation,   // |t| [m]
  kAngleDegrees,  // rotation angle of R [deg], 0 to 180
  kFull,          // Frobenius norm of E - I, dimensionless
};

// Unit of `delta` of the relative error.
enum class DeltaUnit {
  kFrames,  // matched poses
  kMetres,  // path length along the (aligned) estimate
};

// Options of AbsolutePoseError().
struct AbsolutePoseErrorOptions {
  double t_max_diff = 0.02;  // [s] >= 0: stamps further apart do not match
  TrajectoryAlignment alignment = TrajectoryAlignment::kSe3;
  PoseRelation relation = PoseRelation::kTranslation;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of RelativePoseError().
struct RelativePoseErrorOptions {
  double t_max_diff = 0.02;  // [s] >= 0: stamps further apart do not match
  TrajectoryAlignment alignment = TrajectoryAlignment::kNone;
  PoseRelation relation = PoseRelation::kTranslation;
  double delta = 1.0;  // [matched poses], a whole number >= 1, or [m] > 0
  DeltaUnit delta_unit = DeltaUnit::kFrames;
  // One pair starts at every pose; otherwise a pair starts where the previous one ends.
  bool all_pairs = false;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Statistics of n errors e_i, in their unit (sse: squared).
struct ErrorStatistics {
  double max = 0.0;
  double mean = 0.0;
  double median = 0.0;  // for an even number: the mean of the two middle ones
  double min = 0.0;
  double rmse = 0.0;  // sqrt(sse / n)
  double sse = 0.0;   // sum of squares
  double std = 0.0;   // of the population: divided by n
};

// Throws InvalidArgument if `errors` is empty.
ErrorStatistics ComputeStatistics(const std::vector<double>& errors);

// p_A = scale R_AB p_B + t_AB.
struct Similarity {
  double scale = 1.0;
  Pose T_AB;

  // Rotates, scales and moves the position; rotates the attitude.
  Pose operator*(const Pose& T_BC) const;
};

// Returns the similarity (rigid: scale 1) that minimises sum |a_i - (scale R b_i + t)|^2. a, b: 3 x
// n [m]. Empty if the rotation is not determined: fewer than three points, or all on one line.
// Throws InvalidArgument if the sizes differ or a point is not finite. Source: Umeyama,
// "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991,
// Eq. 34-43.
std::optional<Similarity> AlignUmeyama(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                                       bool with_scale);

// Part of the rotation of an alignment that is not observable from the matched positions. The
// translation errors do not depend on it; it is chosen such that the attitude errors are minimal.
enum class OpenRotation {
  kNone,
  kAboutLine,  // all positions lie on a straight line: rotation about it
  kAll,        // all positions lie in one point
};

// Errors of an estimated trajectory and the poses that they refer to.
struct TrajectoryError {
  ErrorStatistics statistics;
  // One per matched pose (APE) or pair of them (RPE): [m], [deg] or none, see PoseRelation.
  std::vector<double> errors;
  // For each error the index into the matched trajectories: of the pose, or of the end of the pair.
  std::vector<std::size_t> indices;
  // The matched poses in pairs; the estimate is aligned and keeps its own stamps.
  Trajectory reference;
  Trajectory estimate;
  double scale = 1.0;  // factor by which the alignment multiplied the estimate
  OpenRotation open_rotation = OpenRotation::kNone;  // of kSe3 and kSim3
  // Fraction of the time covered by the reference that the estimate covers, 0 to 1: the sum of the
  // intervals between neighbouring matched estimates divided by that between neighbouring
  // references, excluding intervals longer than max_gap in both.
  double time_covered = 0.0;
  // Three times the median interval of the sparser trajectory, and at least t_max_diff [ns]: a
  // longer interval is a gap, where the estimate was lost or the reference had no data.
  Stamp max_gap = 0;
};

// Computes the absolute errors E_i = Q_i^-1 P_i of reference Q and aligned estimate P (Sturm 2012,
// section IV-B); for kTranslation the distance of the positions. O(n log n).
// Throws InvalidArgument if an option is out of range, stamps decrease, nothing matches, fewer than
// three poses match for kSe3, kSim3 or kScale, or the scale is not determined.
TrajectoryError AbsolutePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const AbsolutePoseErrorOptions& options = {});

// Computes the relative errors E_ij = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm 2012, Eq. 2) over the
// pairs (i, j):
//   kFrames  delta matched poses apart;
//   kMetres  one after the other: the path is cut at the first pose at or beyond every delta, and
//            each piece but the first is a pair (evo uses the first only to find where to begin);
//            all pairs: from each i the j with the path length nearest to delta, kept where that is
//            within 10 % of delta.
// O(n log n). Throws as above, and InvalidArgument if no two poses are delta apart.
TrajectoryError RelativePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const RelativePoseErrorOptions& options = {});

// A cause of error, or several combined: the values that minimise the remaining error, with
// standard deviations by a jackknife over pieces of the trajectory, because neighbouring errors are
// not independent. Quantities that are not estimated are zero, the scale 1.
struct ErrorCause {
  double time_shift = 0.0, time_shift_sigma = 0.0;  // [s] to be added to the estimate's stamps
  double scale = 1.0, scale_sigma = 0.0;            // factor to be applied to the estimate
  // [m] from the estimate's point to the reference's, in the axes of the estimate's body.
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();
  double rmse = 0.0;  // [m] of the remaining error, aligned anew
};

// Decomposition of an absolute error: result of ExplainError().
struct ErrorExplanation {
  double rmse = 0.0;  // [m] unmodified, the reference interpolated at the estimate's stamps
  // Each cause separately, and combined; empty if the motion does not make it observable, such as a
  // lever arm without rotation, or if the shift exceeds ErrorExplanationOptions::max_time_shift.
  std::optional<ErrorCause> time_shift, scale, time_shift_and_scale, lever_arm, all;
  // [m] RMS of the errors averaged over `slow_seconds`, and of the rest.
  double slow = 0.0, fast = 0.0;
  // Rotation between the axes of the two bodies [rad], in the axes of the estimate's body, and the
  // RMS of the rotation errors [rad] with and without it.
  Eigen::Vector3d hand_eye = Eigen::Vector3d::Zero();
  Eigen::Vector3d hand_eye_sigma = Eigen::Vector3d::Zero();
  double angle_rmse = 0.0, angle_rmse_without = 0.0;
  // [m] error of each matched pose after correction by `all`, else by `time_shift_and_scale`, else
  // without correction; NaN where the reference has a gap at the shifted stamp.
  std::vector<double> left;
};

// Options of ExplainError().
struct ErrorExplanationOptions {
  double slow_seconds = 1.0;    // [s] > 0
  double max_time_shift = 0.5;  // [s] > 0; larger shifts are not searched
  int pieces = 20;              // >= 4; pieces of the jackknife

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// error: AbsolutePoseError(reference, ...) with a rigid alignment. Throws InvalidArgument if fewer
// than 4 poses for each piece are matched, if the estimate was scaled, and on invalid options.
ErrorExplanation ExplainError(const Trajectory& reference, const TrajectoryError& error,
                              const ErrorExplanationOptions& options = {});

}  // namespace highwall
