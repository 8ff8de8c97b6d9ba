#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// Error of a trajectory against the ground truth: absolute error after a rigid alignment, and
// relative error over one second.
struct MotionErrors {
  TrajectoryError absolute;
  TrajectoryError relative;
  int frames_per_second = 1;  // matched poses per interval of the relative error
  Trajectory truth_W;         // in the world of the trajectory, during its time span
};

// Returns an empty result if they cannot be compared, since hardly any of their stamps match.
std::optional<MotionErrors> CompareWithTruth(const Trajectory& truth, const Trajectory& trajectory);

// Returns {"t": [s] after `start`, "position": [m]} of at most about `limit` poses, evenly chosen;
// with `errors` also "error" [m], or null for a pose without one.
nlohmann::json PathJson(const Trajectory& trajectory, Stamp start,
                        const std::optional<MotionErrors>& errors, std::size_t limit);

// Returns {"ape": {...}, "rpe": {...}, "truth": {"t", "position"}, "time_covered"}: each error with
// "rmse", "mean", "median", "max" [m] and its curve "t" [s] after `start`, "error" [m].
nlohmann::json ErrorsJson(const MotionErrors& errors, Stamp start, std::size_t limit);

}  // namespace highwall::apps
