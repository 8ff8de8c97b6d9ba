#include "posed_frames.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "config.h"
#include "json_text.h"

namespace highwall::apps {
namespace {

constexpr Stamp kMaxStampDifference = 20'000'000;  // [ns]

// What run.json holds; not an object where it is not whole.
nlohmann::json ReadReport(const std::filesystem::path& run) {
  std::ifstream stream(run / "run.json");
  return nlohmann::json::parse(stream, nullptr, false);
}

std::string DatasetOfRun(const std::filesystem::path& run, const nlohmann::json& report) {
  if (!report.is_object() || !report.contains("dataset") || !report["dataset"].is_string()) {
    throw IoError(run / "run.json", "does not name a dataset: give --dataset");
  }
  return StringIn(report["dataset"]);
}

std::string CalibrationOfRun(const nlohmann::json& report) {
  const bool told =
      report.is_object() && report.contains("calibration") && report["calibration"].is_string();
  return told ? StringIn(report["calibration"]) : "";
}

bool IsLocalization(const nlohmann::json& report) {
  const nlohmann::json::json_pointer option("/options/localize_only");
  return report.is_object() && report.contains(option) && report.at(option) == true;
}

std::optional<Pose> PoseAt(const Trajectory& trajectory, Stamp stamp) {
  const auto after = std::ranges::lower_bound(trajectory, stamp, {}, &StampedPose::stamp);
  const auto near = [&](auto pose) { return std::abs(pose->stamp - stamp) <= kMaxStampDifference; };
  const bool near_after = after != trajectory.end() && near(after);
  const bool near_before = after != trajectory.begin() && near(std::prev(after));
  if (near_after && near_before) return Interpolate(trajectory, stamp);
  if (near_after) return after->pose;
  if (near_before) return std::prev(after)->pose;
  return std::nullopt;
}

}  // namespace

MapSource ResolveSource(const std::filesystem::path& source, const std::string& dataset,
                        const std::string& trajectory) {
  MapSource resolved;
  const bool run = std::filesystem::exists(source / "run.json");
  if (run) {
    const nlohmann::json report = ReadReport(source);
    if (trajectory.empty() && IsLocalization(report)) {
      throw IoError(source,
                    "is a localization (slam --localize), which makes no keyframes: map the run "
                    "that made its map, or give --trajectory " +
                        (source / "trajectory.txt").string());
    }
    resolved.dataset = dataset.empty() ? DatasetOfRun(source, report) : dataset;
    resolved.run = source;
    resolved.config = ConfigOfRun(CalibrationOfRun(report));
    resolved.trajectory = source / "keyframes.txt";
    resolved.keyframes = true;
    resolved.level = false;
  } else {
    resolved.dataset = dataset.empty() ? source : std::filesystem::path(dataset);
    resolved.trajectory = resolved.dataset / "groundtruth.txt";
  }
  if (!trajectory.empty()) {
    resolved.trajectory = trajectory;
    resolved.keyframes = false;
  }
  if (!std::filesystem::is_directory(resolved.dataset)) {
    throw IoError(resolved.dataset, run ? "is the dataset of the run and not there: give --dataset"
                                        : "is neither a run nor a dataset");
  }
  if (!std::filesystem::exists(resolved.trajectory)) {
    throw IoError(resolved.trajectory, "is not there: give --trajectory");
  }
  return resolved;
}

std::vector<PosedFrame> PosedFrames(const Dataset& dataset, const Trajectory& trajectory,
                                    std::size_t every) {
  std::vector<PosedFrame> frames;
  std::size_t count = 0;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    const std::optional<Pose> T_WC = PoseAt(trajectory, dataset.stamp(i));
    if (T_WC && count++ % every == 0) frames.push_back({i, *T_WC});
  }
  return frames;
}

}  // namespace highwall::apps
