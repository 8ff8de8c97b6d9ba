#include "run_output.h"

#include <exception>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/mapping/point_cloud_io.h>

#include "map_pictures.h"
#include "sparse_map_picture.h"

namespace highwall::apps {
namespace {

constexpr const char* kReport = "run.json";
constexpr const char* kTrajectory = "trajectory.txt";
constexpr const char* kCausal = "trajectory_causal.txt";
constexpr const char* kAdjusted = "trajectory_adjusted.txt";
constexpr const char* kKeyframes = "keyframes.txt";
constexpr const char* kCloud = "cloud.ply";
constexpr const char* kOctree = "map.bt";
constexpr const char* kGrid = "grid.yaml";
constexpr const char* kGridImage = "grid.pgm";
constexpr const char* kSparseMap = "sparse_map.png";

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

// What an earlier run wrote of submaps beside its largest; as many as it had.
void RemoveOfSubmaps(const std::filesystem::path& path) {
  for (std::size_t place = 1;; ++place) {
    const std::filesystem::path file =
        path.parent_path() / NameOfSubmap(path.filename().string(), place);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return;
    RemoveStale(file);
  }
}

// A file that could not be written has none.
void AddFileSize(const std::filesystem::path& path, nlohmann::json& json) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (!error) json["file_mb"] = static_cast<double>(bytes) / 1e6;
}

nlohmann::json DenseJson(const DenseMap& dense, const std::filesystem::path& directory) {
  const OctreeLeafCount leaves = dense.octree.LeafCount();
  nlohmann::json json;
  json["cloud"] = {{"points", dense.cloud.size()}, {"merge_ms", dense.merge_ms}};
  AddFileSize(directory / kCloud, json["cloud"]);
  json["octree"] = {{"resolution_m", dense.octree.options().resolution},
                    {"occupied_leaves", leaves.occupied},
                    {"free_leaves", leaves.free},
                    {"memory_mb", static_cast<double>(dense.octree.MemoryBytes()) / 1e6},
                    {"build_ms", dense.octree_ms}};
  AddFileSize(directory / kOctree, json["octree"]);
  json["grid"] = {{"width", dense.grid.width},
                  {"height", dense.grid.height},
                  {"resolution_m", dense.grid.resolution}};
  if (dense.ground_height) json["grid"]["ground_height_m"] = *dense.ground_height;
  return json;
}

void Append(const StampedPose& pose, std::optional<TrajectoryLog>& log) {
  if (!log) return;
  try {
    log->Append(pose);
  } catch (const IoError&) {
    log.reset();  // in the end the whole file is tried once more
  }
}

}  // namespace

std::string NameOfSubmap(const std::string& name, std::size_t place) {
  if (place == 0) return name;
  const std::filesystem::path path(name);
  return path.stem().string() + "_" + std::to_string(place + 1) + path.extension().string();
}

RunOutput::RunOutput(std::filesystem::path directory, std::filesystem::path saved_map)
    : directory_(std::move(directory)), saved_map_(std::move(saved_map)) {}

void RunOutput::Begin() {
  MakeFolder(directory_);
  if (!saved_map_.empty()) MakeFolder(std::filesystem::absolute(saved_map_).parent_path());
  for (const char* name : {kReport, kTrajectory, kCausal, kAdjusted, kKeyframes, kCloud, kOctree,
                           kGrid, kGridImage, kSparseMap}) {
    RemoveStale(directory_ / name);
  }
  for (const MapPicture& picture : kMapPictures) RemoveStale(directory_ / picture.file);
  for (const char* name : {kTrajectory, kCausal, kAdjusted}) RemoveOfSubmaps(directory_ / name);
  OpenLog(kCausal, causal_);
  OpenLog(kKeyframes, keyframes_);
  begun_ = true;
}

void RunOutput::OpenLog(const char* name, std::optional<TrajectoryLog>& log) const {
  try {
    log.emplace(directory_ / name);
  } catch (const IoError&) {
    log.reset();
  }
}

void RunOutput::Follow(const FrameResult& result) {
  if (!HasPose(result.state)) return;
  if (!begun_) {
    Begin();
    logged_ = result.submap;
  }
  if (result.submap != logged_) return;  // of another world
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
  const bool logged = causal_ && run.largest.submap == logged_;
  causal_.reset();
  const auto write = [&](const char* name, std::size_t place, const Trajectory& trajectory) {
    Attempt([&] { WriteTumTrajectory(directory_ / NameOfSubmap(name, place), trajectory); });
  };
  write(kTrajectory, 0, run.largest.trajectory);
  write(kKeyframes, 0, run.keyframes);
  // The log is what would be written, and on a full disk there may be no room for it twice.
  if (!logged) write(kCausal, 0, run.largest.causal);
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    write(kTrajectory, i + 1, run.others[i].trajectory);
    write(kCausal, i + 1, run.others[i].causal);
  }
}

void RunOutput::WriteDense(const DenseMap& dense, const Trajectory& trajectory) {
  Attempt([&] { dense.octree.WriteBinary(directory_ / kOctree); });
  if (dense.grid.width > 0) {
    Attempt([&] { WriteOccupancyGrid(directory_ / kGrid, dense.grid); });
  }
  Attempt([&] { WritePly(directory_ / kCloud, dense.cloud); });
  for (const MapPicture& picture : kMapPictures) {
    Attempt([&] { WriteMapPicture(directory_, picture, dense, trajectory); });
  }
}

nlohmann::json RunOutput::WriteRest(const SlamRun& run, const nlohmann::json& run_json) {
  failures_.insert(failures_.begin(), run.failures.begin(), run.failures.end());
  if (!run.largest.adjusted.empty()) {
    Attempt([&] { WriteTumTrajectory(directory_ / kAdjusted, run.largest.adjusted); });
    Attempt([&] { WriteTumTrajectory(directory_ / kKeyframes, run.keyframes); });
  }
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    const Trajectory& adjusted = run.others[i].adjusted;
    if (adjusted.empty()) continue;
    Attempt([&] { WriteTumTrajectory(directory_ / NameOfSubmap(kAdjusted, i + 1), adjusted); });
  }
  if (run.dense) WriteDense(*run.dense, run.largest.trajectory);
  Attempt([&] {
    const Eigen::Quaterniond R_GW = run.dense ? run.dense->R_GW : Eigen::Quaterniond::Identity();
    const cv::Mat sparse = DrawSparseMap(run.sparse, R_GW, 1200);
    if (!sparse.empty()) WritePng(directory_ / kSparseMap, sparse);
  });
  nlohmann::json json = run_json;
  if (run.dense) json["map"] = DenseJson(*run.dense, directory_);
  json["complete"] = failures_.empty();
  if (!failures_.empty()) json["failures"] = failures_;
  Attempt([&] {
    AtomicFile file(directory_ / kReport);
    file.stream() << json.dump(2) << '\n';
    file.Commit();
  });
  return json;
}

}  // namespace highwall::apps
