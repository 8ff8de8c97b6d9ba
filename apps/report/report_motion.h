#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// How far a trajectory is from the truth: absolute error after a rigid alignment, relative error
// over a second.
struct MotionErrors {
  TrajectoryError absolute;
  TrajectoryError relative;
  int frames_per_second = 1;  // matched poses that the relative error goes over
  Trajectory truth_W;         // in the world of the trajectory, while that lasts
};

// Empty where they cannot be compared: hardly any stamp of the truth is one of the trajectory.
std::optional<MotionErrors> CompareWithTruth(const Trajectory& truth, const Trajectory& trajectory);

// {"t": [s] after `start`, "position": [m]} of about `limit` poses at most, evenly chosen, and
// "error" [m], or null where a pose has none, with `errors`.
nlohmann::json PathJson(const Trajectory& trajectory, Stamp start,
                        const std::optional<MotionErrors>& errors, std::size_t limit);

// {"ape": {...}, "rpe": {...}, "truth": {"t", "position"}, "time_covered"}: each error with "rmse",
// "mean", "median", "max" [m] and its course "t" [s] after `start`, "error" [m].
nlohmann::json ErrorsJson(const MotionErrors& errors, Stamp start, std::size_t limit);

}  // namespace highwall::apps
