#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

// What the absolute error of a trajectory is made of: how much of it a shift of the clock, a scale
// or another point of the body would take away, and how fast the rest changes. docs/evaluation.md
namespace highwall {

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
