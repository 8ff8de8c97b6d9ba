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
// ExplainError() tells what the absolute error is made of: how much of it a shift of the clock, a
// scale or another point of the body would take away, and how fast the rest changes
// (docs/evaluation.md).

namespace [[gnu::visibility("default")]] highwall {

// How the estimate is moved onto the reference before they are compared.
enum class TrajectoryAlignment {
  kNone,
  kSe3,     // rigid, least squares over all matched positions
  kSim3,    // the same with scale
  kScale,   // that scale alone: positions are multiplied, not moved
  kOrigin,  // the first matched poses laid on each other
};

// Which number an error transform E = (R, t) becomes.
enum class PoseRelation {
  kTranslation,   // |t| [m]
  kAngleDegrees,  // rotation angle of R [deg], 0 to 180
  kFull,          // Frobenius norm of E - I, no unit
};

// What `delta` of the relative error counts.
enum class DeltaUnit {
  kFrames,  // matched poses
  kMetres,  // path length along the (aligned) estimate
};

// Of AbsolutePoseError().
struct AbsolutePoseErrorOptions {
  double t_max_diff = 0.02;  // [s] >= 0: stamps further apart do not match
  TrajectoryAlignment alignment = TrajectoryAlignment::kSe3;
  PoseRelation relation = PoseRelation::kTranslation;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Of RelativePoseError().
struct RelativePoseErrorOptions {
  double t_max_diff = 0.02;  // [s] >= 0: stamps further apart do not match
  TrajectoryAlignment alignment = TrajectoryAlignment::kNone;
  PoseRelation relation = PoseRelation::kTranslation;
  double delta = 1.0;  // [matched poses], a whole number >= 1, or [m] > 0
  DeltaUnit delta_unit = DeltaUnit::kFrames;
  // One pair from every pose on; otherwise a pair begins where the one before it ends.
  bool all_pairs = false;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Of n errors e_i, in their unit (sse: squared).
struct ErrorStatistics {
  double max = 0.0;
  double mean = 0.0;
  double median = 0.0;  // of an even number: the mean of the two in the middle
  double min = 0.0;
  double rmse = 0.0;  // sqrt(sse / n)
  double sse = 0.0;   // sum of squares
  double std = 0.0;   // of the population: divided by n
};

// Throws InvalidArgument if there is no error.
ErrorStatistics ComputeStatistics(const std::vector<double>& errors);

// p_A = scale R_AB p_B + t_AB.
struct Similarity {
  double scale = 1.0;
  Pose T_AB;

  // Rotates, scales and moves the position; rotates the attitude.
  Pose operator*(const Pose& T_BC) const;
};

// The similarity (rigid: scale 1) that minimises sum |a_i - (scale R b_i + t)|^2. a, b: 3 x n [m].
// Throws InvalidArgument if the sizes differ or the rotation is not determined: fewer than three
// points, or all on one line. Source: Umeyama, "Least-squares estimation of transformation
// parameters between two point patterns", PAMI 1991, Eq. 34-43.
Similarity AlignUmeyama(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, bool with_scale);

// What of the rotation of an alignment the matched positions leave open. The translation errors do
// not depend on it; attitudes decide it, so that their errors are the least that it allows.
enum class OpenRotation {
  kNone,
  kAboutLine,  // all positions lie on a straight line: the turn about it
  kAll,        // all positions lie in one point
};

// Errors of an estimated trajectory, and what they are of.
struct TrajectoryError {
  ErrorStatistics statistics;
  // One per matched pose (APE) or pair of them (RPE): [m], [deg] or none, see PoseRelation.
  std::vector<double> errors;
  // For each error the index into the matched trajectories: of the pose, or of the end of the pair.
  std::vector<std::size_t> indices;
  // The matched poses, side by side; the estimate is aligned and keeps its own stamps.
  Trajectory reference;
  Trajectory estimate;
  double scale = 1.0;  // by which the alignment multiplied the estimate
  OpenRotation open_rotation = OpenRotation::kNone;  // of kSe3 and kSim3
  // Share of the time seen by the reference that the estimate covers, 0 to 1: the sum of the
  // intervals between neighbouring matched estimates over that between neighbouring references,
  // leaving out those longer than max_gap in both.
  double time_covered = 0.0;
  // Three times the median interval of the sparser trajectory, and no less than t_max_diff [ns]:
  // a longer interval is a hole, where the estimate was lost or the reference blind.
  Stamp max_gap = 0;
};

// Absolute: E_i = Q_i^-1 P_i of reference Q and aligned estimate P (Sturm 2012, section IV-B); for
// kTranslation the distance of the positions. O(n log n).
// Throws InvalidArgument if an option is out of range, stamps decrease, nothing matches, fewer than
// three poses match for kSe3, kSim3 or kScale, or the scale is not determined.
TrajectoryError AbsolutePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const AbsolutePoseErrorOptions& options = {});

// Relative: E_ij = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) (Sturm 2012, Eq. 2) over the pairs (i, j) that are
//   kFrames  delta matched poses apart;
//   kMetres  one after the other: the path is cut at the first pose at or beyond every delta, and
//            each piece but the first is a pair (evo uses the first only to find where to begin);
//            all pairs: from each i the j with the path length nearest to delta, kept where that is
//            within 10 % of delta.
// O(n log n). Throws as above, and InvalidArgument if no two poses are so far apart.
TrajectoryError RelativePoseError(const Trajectory& reference, const Trajectory& estimate,
                                  const RelativePoseErrorOptions& options = {});

// A cause of error, or several together: the values that take most of it away, with standard
// deviations by a jackknife over pieces of the trajectory, for neighbouring errors are not
// independent. What is not among the causes is zero, with a scale of 1.
struct ErrorCause {
  double time_shift = 0.0, time_shift_sigma = 0.0;  // [s] to be added to the estimate's stamps
  double scale = 1.0, scale_sigma = 0.0;            // by which it is to be multiplied
  // [m] from the estimate's point to the reference's, in the axes of the estimate's body.
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();
  double rmse = 0.0;  // [m] of what is left, aligned anew
};

// What an absolute error is made of: ExplainError().
struct ErrorExplanation {
  double rmse = 0.0;  // [m] as it is, the reference interpolated at the estimate's stamps
  // Each by itself, and together; empty where the motion does not tell, as a lever arm without
  // turns, and where the shift would be beyond ErrorExplanationOptions::max_time_shift.
  std::optional<ErrorCause> time_shift, scale, time_shift_and_scale, lever_arm, all;
  // [m] RMS of what is left of the errors' mean over `slow_seconds`, and of the rest.
  double slow = 0.0, fast = 0.0;
  // A turn between the axes of the two bodies [rad], in those of the estimate's, and the RMS of the
  // rotation errors [rad] with and without it.
  Eigen::Vector3d hand_eye = Eigen::Vector3d::Zero();
  Eigen::Vector3d hand_eye_sigma = Eigen::Vector3d::Zero();
  double angle_rmse = 0.0, angle_rmse_without = 0.0;
  // [m] of each matched pose what all causes that the motion tells leave; NaN where the reference
  // has a hole at the moved stamp.
  std::vector<double> left;
};

// Of ExplainError().
struct ErrorExplanationOptions {
  double slow_seconds = 1.0;    // [s] > 0
  double max_time_shift = 0.5;  // [s] > 0; a larger one is not looked for
  int pieces = 20;              // >= 4; of the jackknife

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// error: AbsolutePoseError(reference, ...) with a rigid alignment. Throws InvalidArgument where
// fewer than 4 poses for each piece are matched, where the estimate was scaled, and on bad options.
ErrorExplanation ExplainError(const Trajectory& reference, const TrajectoryError& error,
                              const ErrorExplanationOptions& options = {});

}  // namespace highwall
