#include "run/posed_frames.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include <nlohmann/json.hpp>

#include <highwall/frontend/input/bag_imu.h>

#include <highwall/core/error.h>

#include "files/json_text.h"
#include "run/run_dataset.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

constexpr Stamp kMaxStampDifference = 20'000'000;  // [ns]

std::filesystem::path DatasetOfRun(const std::filesystem::path& run, const nlohmann::json& report) {
  const std::filesystem::path file = run / kReportFile;
  if (!report.is_object() || !report.contains("dataset") || !report["dataset"].is_string()) {
    throw IoError(file, "does not name a dataset: give --dataset");
  }
  const std::string name = StringIn(report["dataset"]);
  const std::vector<std::filesystem::path> datasets = DatasetsOfRun(run, report);
  if (datasets.empty()) {
    const bool is_absolute = std::filesystem::path(name).is_absolute();
    throw IoError(name, is_absolute ? "is the dataset of the run and not there: give --dataset"
                                    : "is the dataset of the run, and no folder of that name "
                                      "holds its frames: give --dataset");
  }
  if (datasets.size() > 1) {
    throw IoError(file, "names the dataset " + name + " without its folder, which may be " +
                            datasets[0].string() + " or " + datasets[1].string() +
                            ": give --dataset");
  }
  return datasets.front();
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

// Returns the poses of the frames of a run as they were tracked, which a killed run leaves; those
// of a run that has not recognized its loaded map have a name of their own.
std::filesystem::path CausalPoses(const std::filesystem::path& source) {
  const std::filesystem::path first = source / kCausalFile;
  return std::filesystem::exists(first) ? first : source / NameOfSubmap(kCausalFile, 1);
}

// A killed run leaves the poses of its frames, but not the name of its dataset.
bool IsUnfinished(const std::filesystem::path& source) {
  return std::filesystem::exists(CausalPoses(source)) &&
         !std::filesystem::exists(source / kReportFile) &&
         !std::filesystem::exists(source / "rgb.txt");
}

// Suggests the command that maps it.
[[noreturn]] void RefuseUnfinished(const std::filesystem::path& source,
                                   const std::string& dataset) {
  throw IoError(source,
                "is a run that did not end (it has no run.json). Its frames until then: "
                "highwall map " +
                    source.string() + " --dataset " + (dataset.empty() ? "DATASET" : dataset) +
                    " --trajectory " + CausalPoses(source).string() + " --out FOLDER");
}

}  // namespace

MapSource ResolveSource(const std::filesystem::path& source, const std::string& dataset,
                        const std::string& trajectory) {
  MapSource resolved;
  const bool unfinished = IsUnfinished(source);
  if (unfinished && (dataset.empty() || trajectory.empty())) RefuseUnfinished(source, dataset);
  const bool run = std::filesystem::exists(source / kReportFile);
  if (run) {
    const nlohmann::json report = ReadJson(source / kReportFile);
    if (trajectory.empty() && IsLocalization(report)) {
      throw IoError(source,
                    "is a localization (slam --localize), which makes no keyframes: map the run "
                    "that made its map, or give --trajectory " +
                        (source / "trajectory.txt").string());
    }
    resolved.dataset =
        dataset.empty() ? DatasetOfRun(source, report) : std::filesystem::path(dataset);
    resolved.run = source;
    resolved.config = CalibrationOfRun(source, report);
    resolved.images = InputOptionsOfRun(report);
    resolved.trajectory = source / NameOfSubmap(kKeyframesFile, FirstPlace(report));
    resolved.keyframes = true;
    resolved.level = false;
  } else {
    resolved.dataset = dataset.empty() ? source : std::filesystem::path(dataset);
    resolved.trajectory = resolved.dataset / "groundtruth.txt";
    if (unfinished) resolved.level = false;
  }
  if (!trajectory.empty()) {
    resolved.trajectory = trajectory;
    resolved.keyframes = false;
  }
  if (!std::filesystem::is_directory(resolved.dataset) && !IsBag(resolved.dataset)) {
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
