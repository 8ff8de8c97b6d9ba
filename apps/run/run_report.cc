#include "run/run_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <system_error>

#include <ceres/version.h>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include <highwall/core/stamp.h>

#include "run/run_output.h"

namespace highwall::apps {
nlohmann::json ToJson(const TimingStatistics& milliseconds) {
  return {{"mean", milliseconds.mean},   {"median", milliseconds.median},
          {"p95", milliseconds.p95},     {"p99", milliseconds.p99},
          {"worst", milliseconds.worst}, {"count", milliseconds.count}};
}

nlohmann::json ToJson(const StageTimes& times) {
  return {{"points", ToJson(times.points)},     {"lines", ToJson(times.lines)},
          {"features", ToJson(times.features)}, {"pose", ToJson(times.pose)},
          {"tracking", ToJson(times.tracking)}, {"mapping", ToJson(times.mapping)},
          {"frame", ToJson(times.frame)},       {"dense", ToJson(times.dense)},
          {"delay", ToJson(times.delay)}};
}

// "others": threads that are not the system's own, such as the pools of OpenCV and of the solver.
nlohmann::json ToJson(const RunProfile::ProcessorSeconds& seconds) {
  nlohmann::json threads = seconds.threads;
  double others = seconds.process;
  for (const auto& [name, of_thread] : seconds.threads) others -= of_thread;
  threads["others"] = std::max(0.0, others);
  return {{"process", seconds.process}, {"decoding", seconds.decoding}, {"threads", threads}};
}

std::string InertialCouplingOf(const SlamRunOptions& options) {
  if (!options.imu) return "off";
  return ToString(options.slam.inertial.coupling);
}

std::string AbsoluteName(const std::filesystem::path& path) {
  std::error_code error;
  return path.empty() ? "" : std::filesystem::absolute(path, error).string();
}

nlohmann::json ToJson(const MemoryAtRest& memory) {
  nlohmann::json held = nlohmann::json::object();
  for (const MemoryShare& share : memory.held) held[share.holder] = Mib(share);
  return {{"all", memory.mib}, {"peak_before", memory.peak_mib}, {"held", held}};
}

nlohmann::json ToJson(const SlamRunOptions& options) {
  const FrameBuilderOptions& frame = options.slam.frame;
  return {{"points", frame.use_points},
          {"lines", frame.use_lines},
          {"point_detector", ToString(frame.point_detector)},
          {"orb_features", frame.orb.features},
          {"orb_levels", frame.orb.pyramid.levels},
          {"line_detector", ToString(frame.lines.detector)},
          {"line_outliers", ToString(options.slam.measurement.mad_rule)},
          {"weighting", ToString(options.slam.measurement.weighting)},
          {"virtual_baseline_m", options.slam.measurement.baseline},
          {"moving_objects", options.slam.tracker.moving.enabled},
          {"frame_timing", ToString(options.slam.tracker.timing)},
          {"parallel_features", options.slam.threads > 0},
          {"solver_threads", std::max(1, options.slam.threads)},
          {"mapping_in_background", options.slam.threads > 0},
          {"loops", options.slam.loops.enabled},
          {"loops_in_background", options.slam.threads > 0},
          {"adjust_all", options.adjust_all},
          {"dense_map", options.dense},
          {"live", options.live},
          {"loaded_map", AbsoluteName(options.load_map)},
          {"saved_map", AbsoluteName(options.save_map)},
          {"localize_only", options.slam.localize_only},
          {"octree_resolution_m", options.map.octree.resolution},
          {"voxel_m", options.map.cloud.voxel_size},
          {"imu", options.imu ? ToString(options.slam.inertial.weighting.policy) : "off"},
          {"inertial", InertialCouplingOf(options)}};
}

nlohmann::json ToJson(const DepthPattern& pattern) {
  return {{"columns", DepthPattern::kColumns},
          {"rows", DepthPattern::kRows},
          {"values_per_m", std::vector<double>(pattern.nodes.begin(), pattern.nodes.end())},
          {"rms_per_m", pattern.Rms()}};
}

nlohmann::json ToJson(const FrameTiming& timing) {
  return {{"colour_readout", timing.colour_readout},
          {"depth_readout", timing.depth_readout},
          {"depth_delay", timing.depth_delay}};
}

// Factors relative to the prior noise, to three digits. levels: of the pyramid.
nlohmann::json ToJson(const NoiseEstimate& noise, int levels) {
  const auto rounded = [](std::span<const double> factors) {
    auto json = nlohmann::json::array();
    for (const double factor : factors) json.push_back(std::round(1e3 * factor) / 1e3);
    return json;
  };
  const std::span points(noise.point_px);
  const std::span low_contrast(noise.low_contrast_px);
  const std::span refined(noise.refined_px);
  const auto used = static_cast<std::size_t>(levels);
  return {{"point_px_by_level", rounded(points.first(used))},
          {"low_contrast_px_by_level", rounded(low_contrast.first(used))},
          {"refined_px_by_level", rounded(refined.first(used))},
          {"point_depth_by_depth", rounded(noise.point_depth)},
          {"edge_depth_by_depth", rounded(noise.edge_depth)},
          {"line_px_by_length", rounded(noise.line_px)},
          {"line_depth_by_depth", rounded(noise.line_depth)}};
}

nlohmann::json ToJson(const std::vector<ImuState>& states) {
  nlohmann::json json;
  for (const char* key : {"stamp", "gyroscope_bias", "accelerometer_bias", "time_offset"}) {
    json[key] = nlohmann::json::array();
  }
  for (const ImuState& state : states) {
    const ImuBias& b = state.bias;
    json["stamp"].push_back(FormatStamp(state.stamp));
    json["gyroscope_bias"].push_back({b(0), b(1), b(2)});
    json["accelerometer_bias"].push_back({b(3), b(4), b(5)});
    json["time_offset"].push_back(state.time_offset);
  }
  return json;
}

nlohmann::json ToJson(const ExtrinsicsEstimate& found) {
  const auto triple = [](const Eigen::Vector3d& v) { return nlohmann::json{v(0), v(1), v(2)}; };
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T_BC = found.T_BC.Matrix();
  return {{"T_BC", std::vector<double>(T_BC.data(), T_BC.data() + 16)},
          {"lever_arm_m", triple(found.T_BC.p())},
          {"lever_arm_sigma_m", triple(found.lever_arm_sigma)},
          {"lever_arm_seen", found.lever_arm_seen},
          {"rotation_sigma_rad", triple(found.rotation_sigma)},
          {"rotation_seen", found.rotation_seen}};
}

nlohmann::json ToJson(const InertialSummary& inertial) {
  const InertialReport& last = inertial.last;
  nlohmann::json json = {{"status", ToString(last.status)},
                         {"dead_reckoned_frames", inertial.dead_reckoned},
                         {"restarts", inertial.restarts},
                         {"contradicted_intervals", inertial.contradicted},
                         {"saturated_intervals", inertial.saturated},
                         {"mean_weight", inertial.mean_weight},
                         {"reduced_share", inertial.reduced_share},
                         {"innovation_per_dof", inertial.mean_innovation},
                         {"tight_updates", ToJson(inertial.tight)},
                         {"refused_tight_updates", inertial.refused_updates}};
  nlohmann::json& intervals = json["intervals"];
  for (const char* key : {"stamp", "weight", "innovation_per_dof"}) {
    intervals[key] = nlohmann::json::array();
  }
  for (const WeighedInterval& interval : inertial.intervals) {
    intervals["stamp"].push_back(FormatStamp(interval.end));
    intervals["weight"].push_back(interval.weight);
    intervals["innovation_per_dof"].push_back(
        interval.innovation ? nlohmann::json(*interval.innovation) : nlohmann::json());
  }
  if (!inertial.states.empty()) json["states"] = ToJson(inertial.states);
  if (inertial.initialized) json["initialized"] = FormatStamp(*inertial.initialized);
  if (!last.reason.empty()) json["reason"] = last.reason;
  if (inertial.given_up > 0) {
    json["given_up_frames"] = inertial.given_up;
    json["given_up_because"] = inertial.given_up_because;
  }
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
  if (last.extrinsics) json["extrinsics"] = ToJson(*last.extrinsics);
  return json;
}

nlohmann::json ToJson(const GpsSummary& gps) {
  nlohmann::json json = {{"fixes", gps.fixes}, {"used", gps.used}, {"refused", gps.refused}};
  if (!gps.T_GW) return json;
  json["rms"] = gps.rms;
  json["T_GW"] = std::vector<double>(gps.T_GW->data(), gps.T_GW->data() + Pose::kSize);
  return json;
}

nlohmann::json ToJson(const DepthNoise& noise) {
  return {{"offset", noise.offset}, {"quadratic", noise.quadratic}, {"reference", noise.reference}};
}

DepthNoise DepthNoiseOf(const nlohmann::json& report) {
  DepthNoise noise;
  if (!report.contains("depth_noise")) return noise;
  const nlohmann::json& stored = report["depth_noise"];
  noise.offset = stored.value("offset", noise.offset);
  noise.quadratic = stored.value("quadratic", noise.quadratic);
  noise.reference = stored.value("reference", noise.reference);
  noise.Validate();
  return noise;
}

nlohmann::json VersionsJson() {
  return {{"highwall", HIGHWALL_VERSION},
          {"ceres", CERES_VERSION_STRING},
          {"opencv", CV_VERSION},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

nlohmann::json SubmapsJson(const SlamRun& run) {
  nlohmann::json all = nlohmann::json::array();
  const auto add = [&all, &run](const SubmapRun& submap) {
    if (submap.trajectory.empty()) return;
    all.push_back({{"id", submap.submap.value()},
                   {"frames", submap.trajectory.size()},
                   {"keyframes", submap.keyframes},
                   {"first", FormatStamp(submap.trajectory.front().stamp)},
                   {"last", FormatStamp(submap.trajectory.back().stamp)},
                   {"trajectory", NameOfSubmap(kTrajectoryFile, FirstPlace(run) + all.size())}});
  };
  add(run.largest);
  for (const SubmapRun& submap : run.others) add(submap);
  return all;
}

// Reports stamps of frames, because ids have no meaning outside of the run. A keyframe of a loaded
// map has no stamp here.
nlohmann::json LoopEventsJson(const SlamRun& run) {
  nlohmann::json all = nlohmann::json::array();
  const auto add_stamp = [&run](const char* key, KeyFrameId id, nlohmann::json* json) {
    const auto stamp = run.keyframe_stamps.find(id);
    if (stamp != run.keyframe_stamps.end()) (*json)[key] = FormatStamp(stamp->second);
  };
  for (const LoopEvent& event : run.loop_events) {
    nlohmann::json json = {{"keyframe", event.edge.keyframe.value()},
                           {"match", event.edge.match.value()},
                           {"result", !event.accepted ? "refused"
                                      : event.merged  ? "merged"
                                                      : "closed"}};
    add_stamp("keyframe_stamp", event.edge.keyframe, &json);
    add_stamp("match_stamp", event.edge.match, &json);
    if (!event.accepted) json["because"] = event.message;
    all.push_back(std::move(json));
  }
  return all;
}

nlohmann::json ToJson(const std::vector<TrackedFrame>& frames) {
  nlohmann::json json;
  for (const char* key : {"stamp", "points", "lines", "milliseconds"}) {
    json[key] = nlohmann::json::array();
  }
  for (const TrackedFrame& frame : frames) {
    json["stamp"].push_back(FormatStamp(frame.stamp));
    json["points"].push_back(frame.points);
    json["lines"].push_back(frame.lines);
    json["milliseconds"].push_back(std::round(frame.milliseconds * 100.0) / 100.0);
  }
  return json;
}

nlohmann::json ToJson(const SensorVerdict& verdict) {
  nlohmann::json findings = nlohmann::json::array();
  for (const SensorFinding& finding : verdict.findings) {
    findings.push_back({{"fault", ToString(finding.fault)},
                        {"trust", ToString(finding.trust)},
                        {"text", finding.text},
                        {"remedy", finding.remedy}});
  }
  return {{"trust", ToString(verdict.trust())}, {"findings", findings}};
}

nlohmann::json RunJson(const SlamRun& run, const SlamRunOptions& options,
                       const std::string& dataset, const std::string& calibration) {
  std::error_code is_no_path;
  const bool is_file = std::filesystem::is_regular_file(calibration, is_no_path);
  nlohmann::json lost = nlohmann::json::array();
  for (const Stamp stamp : run.lost) lost.push_back(FormatStamp(stamp));
  nlohmann::json json = {
      {"versions", VersionsJson()},
      {"dataset", AbsoluteName(dataset)},
      {"calibration", is_file ? AbsoluteName(calibration) : calibration},
      {"options", ToJson(options)},
      {"frames", run.frames},
      {"skipped_frames", run.skipped},
      {"dropped_frames", run.dropped},
      {"postponed",
       {{"keyframes", run.postponed.keyframes}, {"loop_searches", run.postponed.loop_searches}}},
      {"tracked_frames", (run.frames - run.lost.size())},
      {"colour_images", CountColourImages(run)},
      {"without_depth", run.without_depth},
      {"coverage", ColourCoverage(run)},
      {"lost_frames", run.lost.size()},
      {"lost_stamps", lost},
      {"lost_because", run.lost_because},
      {"loss_reasons", run.loss_reasons},
      {"repeated_images", run.repeated},
      {"late_colour", ToJson(run.late_colour)},
      {"refined_frames", run.refined},
      {"relocalizations", run.relocalizations},
      {"open_frames", run.open_frames},
      {"loops",
       {{"closed", run.loops.closed},
        {"refused", run.loops.refused},
        {"merges", run.loops.merges},
        {"events", LoopEventsJson(run)},
        {"fused_points", run.loops.fused_points},
        {"fused_lines", run.loops.fused_lines},
        {"worst_seconds", run.loops.worst_seconds}}},
      {"adjustments",
       {{"all", run.adjustments.all},
        {"refused", run.adjustments.refused},
        {"failed", run.adjustments.failed},
        {"unmoved", run.adjustments.unmoved},
        {"rejected_steps", run.adjustments.rejected_steps}}},
      {"submaps", SubmapsJson(run)},
      {"keyframes", run.keyframes.size()},
      {"keyframes_made", run.keyframes_made},
      {"landmarks", {{"points", run.points}, {"lines", run.lines}}},
      {"matched_per_frame", {{"points", run.matched_points}, {"lines", run.matched_lines}}},
      {"per_frame", ToJson(run.per_frame)},
      {"memory_at_rest_mib", ToJson(run.memory)},
      {"frame_timing_s",
       {{"value", ToJson(run.sensor.timing.value)},
        {"sigma", ToJson(run.sensor.timing.sigma)},
        {"direction", ToString(run.sensor.timing.value.direction)}}},
      {"depth_pattern", ToJson(run.sensor.depth_pattern)},
      {"noise", ToJson(run.sensor.noise, run.levels)},
      {"verdict", ToJson(run.verdict)},
      {"milliseconds", ToJson(run.times)},
      {"seconds", run.seconds},
      {"processor_seconds", ToJson(run.processor)},
      {"processor_ms_per_frame", ProcessorMsPerFrame(run)}};
  if (!options.load_map.empty()) json["loaded_map_met"] = run.map_met;
  if (run.inertial) json["imu"] = ToJson(*run.inertial);
  if (run.gps) json["gps"] = ToJson(*run.gps);
  return json;
}

}  // namespace highwall::apps
