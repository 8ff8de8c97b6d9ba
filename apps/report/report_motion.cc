#include "report/report_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

#include "report/report_number.h"

namespace highwall::apps {
namespace {

// Returns the number of matched poses per second.
int FramesPerSecond(const Trajectory& matched) {
  std::vector<Stamp> intervals;
  for (std::size_t i = 1; i < matched.size(); ++i) {
    intervals.push_back(matched[i].stamp - matched[i - 1].stamp);
  }
  if (intervals.empty()) return 1;
  std::ranges::nth_element(intervals, intervals.begin() + intervals.size() / 2);
  const double interval = ToSeconds(intervals[intervals.size() / 2]);
  return interval > 0.0 ? std::max(1, static_cast<int>(std::lround(1.0 / interval))) : 1;
}

// Returns the ground truth during the trajectory's time span, in the trajectory's world.
Trajectory InWorld(const Trajectory& truth, const Trajectory& trajectory,
                   const TrajectoryError& aligned) {
  const StampedPose& first = aligned.estimate.front();
  const auto original = std::ranges::lower_bound(trajectory, first.stamp, {}, &StampedPose::stamp);
  const Pose T_W_truth = original->pose * first.pose.Inverse();
  Trajectory moved;
  for (const StampedPose& stamped : truth) {
    if (stamped.stamp < trajectory.front().stamp || stamped.stamp > trajectory.back().stamp)
      continue;
    moved.push_back({stamped.stamp, T_W_truth * stamped.pose});
  }
  return moved;
}

std::size_t StrideOf(std::size_t count, std::size_t limit) {
  return std::max<std::size_t>(1, (count + limit - 1) / limit);
}

double Seconds(Stamp stamp, Stamp start) {
  return Rounded(ToSeconds(stamp - start), 1e-4);
}

nlohmann::json CourseJson(const TrajectoryError& error, Stamp start, std::size_t limit) {
  nlohmann::json t = nlohmann::json::array(), e = nlohmann::json::array();
  const std::size_t stride = StrideOf(error.errors.size(), limit);
  for (std::size_t i = 0; i < error.errors.size(); i += stride) {
    t.push_back(Seconds(error.estimate[error.indices[i]].stamp, start));
    e.push_back(Rounded(error.errors[i], 1e-6));
  }
  const ErrorStatistics& s = error.statistics;
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"max", s.max},   {"t", t},         {"error", e}};
}

}  // namespace

std::optional<MotionErrors> CompareWithTruth(const Trajectory& truth,
                                             const Trajectory& trajectory) {
  try {
    MotionErrors errors;
    errors.absolute = AbsolutePoseError(truth, trajectory);
    const int matched = static_cast<int>(errors.absolute.estimate.size());
    errors.frames_per_second =
        std::clamp(FramesPerSecond(errors.absolute.estimate), 1, std::max(1, matched - 1));
    errors.relative = RelativePoseError(
        truth, trajectory,
        {.delta = static_cast<double>(errors.frames_per_second), .all_pairs = true});
    errors.truth_W = InWorld(truth, trajectory, errors.absolute);
    return errors;
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
}

nlohmann::json PathJson(const Trajectory& trajectory, Stamp start,
                        const std::optional<MotionErrors>& errors, std::size_t limit) {
  std::map<Stamp, double> error_at;
  if (errors) {
    const TrajectoryError& e = errors->absolute;
    for (std::size_t i = 0; i < e.errors.size(); ++i) {
      error_at[e.estimate[e.indices[i]].stamp] = e.errors[i];
    }
  }
  nlohmann::json path = {{"t", nlohmann::json::array()}, {"position", nlohmann::json::array()}};
  const std::size_t stride = StrideOf(trajectory.size(), limit);
  for (std::size_t i = 0; i < trajectory.size(); i += stride) {
    path["t"].push_back(Seconds(trajectory[i].stamp, start));
    path["position"].push_back(PositionJson(trajectory[i].pose.p()));
    if (!errors) continue;
    const auto error = error_at.find(trajectory[i].stamp);
    path["error"].push_back(error == error_at.end() ? nlohmann::json()
                                                    : nlohmann::json(Rounded(error->second, 1e-6)));
  }
  return path;
}

nlohmann::json ErrorsJson(const MotionErrors& errors, Stamp start, std::size_t limit) {
  nlohmann::json json = {{"ape", CourseJson(errors.absolute, start, limit)},
                         {"rpe", CourseJson(errors.relative, start, limit)},
                         {"truth", PathJson(errors.truth_W, start, std::nullopt, limit)},
                         {"time_covered", errors.absolute.time_covered}};
  json["rpe"]["frames"] = errors.frames_per_second;
  return json;
}

}  // namespace highwall::apps
