#include "run/run_output.h"

#include <algorithm>
#include <array>
#include <exception>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/mapping/point_cloud_io.h>

#include "files/json_text.h"
#include "plots/map_pictures.h"
#include "plots/sparse_map_picture.h"
#include "run/imu_plot.h"
#include "run/process_memory.h"
#include "run/velocity_file.h"

namespace highwall::apps {
namespace {

constexpr const char* kGrid = "grid.yaml";
constexpr const char* kGridImage = "grid.pgm";
constexpr const char* kImuPlot = "imu.svg";

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder, "cannot be made: " + error.message());
  RemoveTemporariesOfDeadProcesses(folder);
}

void RemoveStale(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw IoError(path, "is of an earlier run and cannot be removed: " + error.message());
}

// Whether `file` is NameOfSubmap(name, place) of some place > 0.
bool IsOfSubmap(const std::string& file, const std::filesystem::path& name) {
  const std::string prefix = name.stem().string() + "_", suffix = name.extension().string();
  if (!file.starts_with(prefix) || !file.ends_with(suffix)) return false;
  if (file.size() <= prefix.size() + suffix.size()) return false;
  const auto number =
      std::string_view(file).substr(prefix.size(), file.size() - prefix.size() - suffix.size());
  return std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
}

bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  return std::filesystem::equivalent(a, b, error);
}

// Whether `file` is TrajectoryOfRun() of some run, in any submap.
bool IsOfRun(const std::string& file) {
  static const std::regex pattern(R"(trajectory_run[0-9]+(_[0-9]+)?\.txt)");
  return std::regex_match(file, pattern);
}

// Removes the results of an earlier run, including those of other submaps.
void RemoveResults(const std::filesystem::path& folder,
                   std::span<const std::filesystem::path> kept) {
  std::vector<const char*> names = {
      kReportFile,   kTrajectoryFile, kVelocitiesFile, kCausalFile, kCovariancesFile,
      kAdjustedFile, kKeyframesFile,  kCloudFile,      kOctreeFile, kGrid,
      kGridImage,    kSparseMapFile,  kImuPlot,        kReportPage};
  for (const MapPicture& picture : kMapPictures) names.push_back(picture.file);
  for (const char* const name : names) RemoveStale(folder / name);
  const std::filesystem::path map = folder / kMapFile;
  if (std::ranges::none_of(kept, [&](const auto& file) { return IsSameFile(file, map); })) {
    RemoveStale(map);
  }
  std::vector<std::filesystem::path> numbered;
  std::error_code error;
  const std::filesystem::directory_iterator entries(folder, error);
  if (error) throw IoError(folder, "cannot be listed: " + error.message());
  for (const auto& entry : entries) {
    const std::string file = entry.path().filename().string();
    const auto is_of = [&file](const char* name) { return IsOfSubmap(file, name); };
    if (IsOfRun(file) || std::ranges::any_of(names, is_of)) {
      numbered.push_back(entry.path());
    }
  }
  for (const std::filesystem::path& path : numbered) RemoveStale(path);
}

// A file that could not be written has no size.
void AddFileSize(const std::filesystem::path& path, nlohmann::json& json) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (!error) json["file_mb"] = static_cast<double>(bytes) / 1e6;
}

// place: of its submap.
nlohmann::json DenseJson(const DenseMap& dense, const std::filesystem::path& directory,
                         std::size_t place) {
  const OctreeLeafCount leaves = dense.octree.LeafCount();
  nlohmann::json json;
  json["cloud"] = {{"points", dense.cloud.size()}, {"merge_ms", dense.merge_ms}};
  AddFileSize(directory / NameOfSubmap(kCloudFile, place), json["cloud"]);
  json["octree"] = {{"resolution_m", dense.octree.options().resolution},
                    {"occupied_leaves", leaves.occupied},
                    {"free_leaves", leaves.free},
                    {"memory_mb", static_cast<double>(dense.octree.MemoryBytes()) / 1e6},
                    {"build_ms", dense.octree_ms}};
  AddFileSize(directory / NameOfSubmap(kOctreeFile, place), json["octree"]);
  json["grid"] = {{"width", dense.grid.width},
                  {"height", dense.grid.height},
                  {"resolution_m", dense.grid.resolution}};
  const Eigen::Vector3d up_W = dense.R_GW.conjugate() * Eigen::Vector3d::UnitZ();
  json["up_W"] = {up_W.x(), up_W.y(), up_W.z()};
  if (dense.ground_height) json["grid"]["ground_height_m"] = *dense.ground_height;
  return json;
}

void Append(const StampedPose& pose, std::optional<TrajectoryLog>& log) {
  if (!log) return;
  try {
    log->Append(pose);
  } catch (const IoError&) {
    log.reset();  // the whole file is written again at the end
  }
}

}  // namespace

std::size_t FirstPlace(const SlamRun& run) {
  return run.map_met ? 0 : 1;
}

void BeginFolder(const std::filesystem::path& folder, std::span<const std::filesystem::path> kept) {
  MakeFolder(folder);
  RemoveResults(folder, kept);
}

void WriteReport(const std::filesystem::path& folder, const nlohmann::json& report) {
  AtomicFile file(folder / kReportFile);
  file.stream() << JsonText(report, 2) << '\n';
  file.Commit();
}

RunOutput::RunOutput(std::filesystem::path directory, std::filesystem::path saved_map,
                     std::filesystem::path loaded_map)
    : directory_(std::move(directory)),
      saved_map_(std::move(saved_map)),
      loaded_map_(std::move(loaded_map)) {}

void RunOutput::Begin() {
  if (!saved_map_.empty()) MakeFolder(std::filesystem::absolute(saved_map_).parent_path());
  BeginFolder(directory_, std::array{saved_map_, loaded_map_});
  OpenLog(kCausalFile, causal_);
  OpenLog(kKeyframesFile, keyframes_);
  if (keeps_covariances_) Attempt([&] { covariances_.emplace(directory_ / kCovariancesFile); });
  begun_ = true;
}

std::filesystem::path RunOutput::PathAt(const char* name, std::size_t place) const {
  return directory_ / NameOfSubmap(name, place);
}

void RunOutput::OpenLog(const char* name, std::optional<TrajectoryLog>& log) const {
  try {
    log.emplace(PathAt(name, logged_place_));
  } catch (const IoError&) {
    log.reset();
  }
}

void RunOutput::Follow(const FrameResult& result) {
  if (!HasPose(result.state)) return;
  if (!begun_) {
    logged_place_ = !loaded_map_.empty() && result.begins_submap ? 1 : 0;
    Begin();
    logged_ = result.submap;
  }
  if (covariances_) {
    Attempt([&] {
      // Gone if it throws: a file with a gap would mislead.
      std::optional<CovarianceLog> log = std::exchange(covariances_, std::nullopt);
      log->Append(result.stamp, result.uncertainty.value().in_map);
      covariances_ = std::move(log);
    });
  }
  if (result.submap != logged_) return;  // another world
  const StampedPose pose{result.stamp, result.T_WC};
  Append(pose, causal_);
  if (result.mapping) Append(pose, keyframes_);
}

void RunOutput::Attempt(const std::function<void()>& write) {
  try {
    write();
  } catch (const std::exception& error) {
    failures_.push_back(error.what());
  }
}

void RunOutput::WriteTrajectories(const SlamRun& run) {
  keyframes_.reset();
  covariances_.reset();
  const std::size_t first = FirstPlace(run);
  const bool logged = causal_ && run.largest.submap == logged_ && logged_place_ == first;
  causal_.reset();
  const auto write = [&](const char* name, std::size_t place, const Trajectory& trajectory) {
    Attempt([&] { WriteTumTrajectory(PathAt(name, place), trajectory); });
  };
  if (!logged) {
    for (const char* name : {kCausalFile, kKeyframesFile}) {
      Attempt([&] { RemoveStale(PathAt(name, logged_place_)); });
    }
  }
  const auto write_final = [&](const SubmapRun& submap, std::size_t place) {
    write(kTrajectoryFile, place, submap.trajectory);
    if (submap.velocities.empty()) return;
    Attempt([&] { WriteVelocities(PathAt(kVelocitiesFile, place), submap.velocities); });
  };
  write_final(run.largest, first);
  write(kKeyframesFile, first, run.keyframes);
  // The log already has this content, and a full disk may have no room for a second copy.
  if (!logged) write(kCausalFile, first, run.largest.causal);
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    write_final(run.others[i], first + i + 1);
    write(kCausalFile, first + i + 1, run.others[i].causal);
  }
}

void RunOutput::WriteDense(const SubmapRun& submap, std::size_t place) {
  if (!submap.dense) return;
  const DenseMap& dense = *submap.dense;
  const auto path = [&](const char* name) { return PathAt(name, place); };
  Attempt([&] { dense.octree.WriteBinary(path(kOctreeFile)); });
  if (dense.grid.width > 0) Attempt([&] { WriteOccupancyGrid(path(kGrid), dense.grid); });
  Attempt([&] { WritePly(path(kCloudFile), dense.cloud); });
  for (const MapPicture& picture : kMapPictures) {
    Attempt([&] { WriteMapPicture(path(picture.file), picture, dense, submap.trajectory); });
  }
}

nlohmann::json RunOutput::WriteRest(const SlamRun& run, const nlohmann::json& run_json) {
  failures_.insert(failures_.begin(), run.failures.begin(), run.failures.end());
  const std::size_t first = FirstPlace(run);
  if (!run.largest.adjusted.empty()) {
    Attempt([&] { WriteTumTrajectory(PathAt(kAdjustedFile, first), run.largest.adjusted); });
    Attempt([&] { WriteTumTrajectory(PathAt(kKeyframesFile, first), run.keyframes); });
  }
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    const Trajectory& adjusted = run.others[i].adjusted;
    if (adjusted.empty()) continue;
    Attempt([&] { WriteTumTrajectory(PathAt(kAdjustedFile, first + i + 1), adjusted); });
  }
  ReturnFreeMemory();
  WriteDense(run.largest, first);
  for (std::size_t i = 0; i < run.others.size(); ++i) WriteDense(run.others[i], first + i + 1);
  const std::optional<DenseMap>& dense = run.largest.dense;
  Attempt([&] {
    const Eigen::Quaterniond R_GW = dense ? dense->R_GW : Eigen::Quaterniond::Identity();
    const cv::Mat sparse = DrawSparseMap(run.sparse, R_GW, 1200);
    if (!sparse.empty()) WritePng(PathAt(kSparseMapFile, first), sparse);
  });
  if (run.inertial && !run.inertial->intervals.empty()) {
    Attempt([&] { WriteImuPlot(directory_ / kImuPlot, *run.inertial); });
  }
  nlohmann::json json = run_json;
  if (dense) json["map"] = DenseJson(*dense, directory_, first);
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    const std::optional<DenseMap>& other = run.others[i].dense;
    if (other) json["submaps"][i + 1]["map"] = DenseJson(*other, directory_, first + i + 1);
  }
  json["complete"] = failures_.empty();
  if (!failures_.empty()) json["failures"] = failures_;
  json["peak_memory_mib"] = PeakMemoryMib();  // including maps and pictures
  Attempt([&] { WriteReport(directory_, json); });
  return json;
}

}  // namespace highwall::apps
