#include "run/depth_of_run.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/features/depth_correction.h>
#include <highwall/frontend/input/depth_stamp.h>

#include "files/json_text.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

using JsonPlace = nlohmann::json::json_pointer;

// Interpolates the motion at a stamp from the poses before and after it; zero if one is too far
// away.
Twist MotionAt(const Trajectory& trajectory, Stamp stamp) {
  constexpr Stamp kLongest = 250'000'000;  // [ns] of constant velocity
  const auto after = std::ranges::upper_bound(trajectory, stamp, {}, &StampedPose::stamp);
  auto before = std::ranges::lower_bound(trajectory, stamp, {}, &StampedPose::stamp);
  if (before == trajectory.begin() || after == trajectory.end()) return {};
  --before;
  const Stamp between = after->stamp - before->stamp;
  if (between > kLongest) return {};
  return Twist::Between(before->pose.Inverse() * after->pose, ToSeconds(between));
}

DepthPattern PatternOf(const nlohmann::json& report) {
  DepthPattern pattern;
  const std::vector<double> values =
      report.value(JsonPlace("/depth_pattern/values_per_m"), std::vector<double>());
  if (values.size() == DepthPattern::kNodes) std::ranges::copy(values, pattern.nodes.begin());
  return pattern;
}

// Reports of older versions state no direction.
FrameTiming TimingOf(const nlohmann::json& report) {
  const nlohmann::json value =
      report.value(JsonPlace("/frame_timing_s/value"), nlohmann::json::object());
  return {.colour_readout = value.value("colour_readout", 0.0),
          .depth_readout = value.value("depth_readout", 0.0),
          .depth_delay = value.value("depth_delay", 0.0),
          .direction = ReadoutDirectionOf(report.value(JsonPlace("/frame_timing_s/direction"), ""))
                           .value_or(ReadoutDirection::kDown)};
}

}  // namespace

DepthOfRun::DepthOfRun(const std::filesystem::path& run) {
  const nlohmann::json report = ReadJson(run / "run.json");
  if (!report.is_object()) throw IoError(run / "run.json", "is damaged: run highwall slam again");
  try {
    pattern_ = PatternOf(report);
    timing_ = TimingOf(report);
    pattern_.Validate();
    timing_.Validate();
    const std::string rows = report.value(JsonPlace("/options/frame_timing"), "ignored");
    const std::filesystem::path poses = run / NameOfSubmap(kTrajectoryFile, FirstPlace(report));
    if (rows == "ignored" || !std::filesystem::exists(poses)) return;
    trajectory_ = ReadTumTrajectory(poses);
  } catch (const nlohmann::json::exception& error) {
    throw IoError(run / "run.json", std::string("is not that of a run: ") + error.what());
  } catch (const InvalidArgument& error) {
    throw IoError(run / "run.json", error.what());
  }
}

cv::Mat DepthOfRun::Correct(const RgbdImage& image, const PinholeCamera& camera) const {
  DepthCorrection correction{pattern_, timing_, MotionAt(trajectory_, image.stamp)};
  correction.timing.depth_delay += DepthDelay(image);
  return correction.Apply(image.depth, camera);
}

}  // namespace highwall::apps
