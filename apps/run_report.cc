#include "run_report.h"

#include <system_error>

#include <ceres/version.h>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/mapping/point_cloud_io.h>

#include "map_pictures.h"
#include "sparse_map_picture.h"

namespace highwall::apps {
namespace {

double FileMegabytes(const std::filesystem::path& path) {
  return static_cast<double>(std::filesystem::file_size(path)) / 1e6;
}

nlohmann::json DenseJson(const DenseMap& dense, const std::filesystem::path& directory) {
  const OctreeLeafCount leaves = dense.octree.LeafCount();
  nlohmann::json json;
  json["cloud"] = {{"points", dense.cloud.size()},
                   {"file_mb", FileMegabytes(directory / "cloud.ply")},
                   {"merge_ms", dense.merge_ms}};
  json["octree"] = {{"resolution_m", dense.octree.options().resolution},
                    {"occupied_leaves", leaves.occupied},
                    {"free_leaves", leaves.free},
                    {"memory_mb", static_cast<double>(dense.octree.MemoryBytes()) / 1e6},
                    {"file_mb", FileMegabytes(directory / "map.bt")},
                    {"build_ms", dense.octree_ms}};
  json["grid"] = {{"width", dense.grid.width},
                  {"height", dense.grid.height},
                  {"resolution_m", dense.grid.resolution}};
  if (dense.ground_height) json["grid"]["ground_height_m"] = *dense.ground_height;
  return json;
}

// A map of an earlier run must not pass for one of this run.
void RemoveStale(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw IoError(path, "is of an earlier run and cannot be removed: " + error.message());
}

void WriteDense(const std::filesystem::path& directory, const std::optional<DenseMap>& dense,
                const Trajectory& trajectory) {
  for (const char* picture : {"cloud_top.png", "cloud.png", "octree_top.png", "octree.png"}) {
    RemoveStale(directory / picture);
  }
  if (dense) {
    WriteMapPictures(directory, *dense, trajectory);
    WritePly(directory / "cloud.ply", dense->cloud);
    dense->octree.WriteBinary(directory / "map.bt");
  } else {
    RemoveStale(directory / "cloud.ply");
    RemoveStale(directory / "map.bt");
  }
  if (dense && dense->grid.width > 0) {
    WriteOccupancyGrid(directory / "grid.yaml", dense->grid);
  } else {
    RemoveStale(directory / "grid.yaml");
    RemoveStale(directory / "grid.pgm");
  }
}

}  // namespace

nlohmann::json ToJson(const Milliseconds& milliseconds) {
  return {{"mean", milliseconds.mean},
          {"median", milliseconds.median},
          {"p95", milliseconds.p95},
          {"p99", milliseconds.p99},
          {"count", milliseconds.count}};
}

nlohmann::json ToJson(const StageTimes& times) {
  return {{"points", ToJson(times.points)},     {"lines", ToJson(times.lines)},
          {"features", ToJson(times.features)}, {"pose", ToJson(times.pose)},
          {"tracking", ToJson(times.tracking)}, {"mapping", ToJson(times.mapping)},
          {"frame", ToJson(times.frame)},       {"dense", ToJson(times.dense)}};
}

nlohmann::json ToJson(const SlamRunOptions& options) {
  const FrameBuilderOptions& frame = options.slam.frame;
  return {{"points", frame.use_points},
          {"lines", frame.use_lines},
          {"orb_features", frame.orb.features},
          {"orb_levels", frame.orb.levels},
          {"line_detector", ToString(frame.lines.detector)},
          {"line_outliers", ToString(options.slam.tracker.matcher.lines.mad_rule)},
          {"weighting", ToString(options.slam.measurement.weighting)},
          {"virtual_baseline_m", options.slam.measurement.baseline},
          {"moving_objects", options.slam.tracker.moving.enabled},
          {"parallel_features", frame.parallel},
          {"solver_threads", options.slam.mapper.bundle.threads},
          {"mapping_in_background", options.slam.mapper.background},
          {"loops", options.slam.loops.enabled},
          {"loops_in_background", options.slam.loops.background},
          {"loaded_map", options.load_map.string()},
          {"localize_only", options.slam.localize_only},
          {"octree_resolution_m", options.map.octree.resolution},
          {"voxel_m", options.map.cloud.voxel_size},
          {"imu", options.imu ? ToString(options.slam.inertial.weighting.policy) : "off"}};
}

nlohmann::json ToJson(const InertialSummary& inertial) {
  const InertialReport& last = inertial.last;
  nlohmann::json json = {
      {"status", ToString(last.status)},         {"dead_reckoned_frames", inertial.dead_reckoned},
      {"restarts", inertial.restarts},           {"mean_weight", inertial.mean_weight},
      {"reduced_share", inertial.reduced_share}, {"innovation_per_dof", inertial.mean_innovation}};
  if (inertial.initialized) json["initialized"] = FormatStamp(*inertial.initialized);
  if (!last.reason.empty()) json["reason"] = last.reason;
  if (const auto& depth = inertial.depth_scale) {
    json["depth_scale"] = {{"value", depth->scale},
                           {"sigma", depth->sigma},
                           {"keyframes", depth->keyframes},
                           {"chi2_per_dof", depth->error}};
  }
  if (!last.estimate) return json;
  const auto triple = [](const auto& v) { return nlohmann::json{v(0), v(1), v(2)}; };
  const ImuBias& bias = last.estimate->bias;
  const ImuBias sigma = last.estimate->covariance.diagonal().tail<6>().cwiseSqrt();
  json["gyroscope_bias"] = {{"value", triple(bias.head<3>())}, {"sigma", triple(sigma.head<3>())}};
  json["accelerometer_bias"] = {{"value", triple(bias.tail<3>())},
                                {"sigma", triple(sigma.tail<3>())}};
  json["time_offset"] = {{"value", last.time_offset}, {"sigma", last.time_offset_sigma}};
  json["gravity_sigma_rad"] = last.gravity_sigma;
  return json;
}

nlohmann::json VersionsJson() {
  return {{"highwall", HIGHWALL_VERSION},
          {"ceres", CERES_VERSION_STRING},
          {"opencv", CV_VERSION},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

nlohmann::json RunJson(const SlamRun& run, const SlamRunOptions& options,
                       const std::string& dataset, const std::string& calibration) {
  nlohmann::json lost = nlohmann::json::array();
  for (const Stamp stamp : run.lost) lost.push_back(FormatStamp(stamp));
  nlohmann::json json = {
      {"versions", VersionsJson()},
      {"dataset", dataset},
      {"calibration", calibration},
      {"options", ToJson(options)},
      {"frames", run.frames},
      {"skipped_frames", run.skipped},
      {"dropped_frames", run.dropped},
      {"tracked_frames", run.trajectory.size()},
      {"lost_frames", run.lost.size()},
      {"lost_stamps", lost},
      {"relocalizations", run.relocalizations},
      {"open_frames", run.open_frames},
      {"loops",
       {{"closed", run.loops.closed},
        {"refused", run.loops.refused},
        {"fused_points", run.loops.fused_points},
        {"fused_lines", run.loops.fused_lines},
        {"worst_seconds", run.loops.worst_seconds}}},
      {"keyframes", run.keyframes.size()},
      {"keyframes_made", run.keyframes_made},
      {"landmarks", {{"points", run.points}, {"lines", run.lines}}},
      {"matched_per_frame", {{"points", run.matched_points}, {"lines", run.matched_lines}}},
      {"milliseconds", ToJson(run.times)},
      {"seconds", run.seconds},
      {"peak_memory_mib", PeakMemoryMib()}};
  if (run.inertial) json["imu"] = ToJson(*run.inertial);
  return json;
}

nlohmann::json WriteRun(const std::filesystem::path& directory, const SlamRun& run,
                        const nlohmann::json& run_json) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw IoError(directory, "cannot be made: " + error.message());
  WriteTumTrajectory(directory / "trajectory.txt", run.trajectory);
  WriteTumTrajectory(directory / "trajectory_causal.txt", run.causal);
  if (run.adjusted.empty()) {
    RemoveStale(directory / "trajectory_adjusted.txt");
  } else {
    WriteTumTrajectory(directory / "trajectory_adjusted.txt", run.adjusted);
  }
  WriteTumTrajectory(directory / "keyframes.txt", run.keyframes);
  nlohmann::json json = run_json;
  WriteDense(directory, run.dense, run.trajectory);
  const Eigen::Quaterniond R_GW = run.dense ? run.dense->R_GW : Eigen::Quaterniond::Identity();
  const cv::Mat sparse = DrawSparseMap(run.sparse, R_GW, 1200);
  if (!sparse.empty()) WritePng(directory / "sparse_map.png", sparse);
  if (run.dense) json["map"] = DenseJson(*run.dense, directory);
  AtomicFile file(directory / "run.json");
  file.stream() << json.dump(2) << '\n';
  file.Commit();
  return json;
}

}  // namespace highwall::apps
