// highwall slam: estimates trajectory and map of a dataset and writes the results and a report.
#include <signal.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include <highwall/core/error.h>
#include <highwall/mapping/octree_size.h>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/stop_signals.h"
#include "files/json_text.h"
#include "report/html_report.h"
#include "run/depth_camera.h"
#include "run/folder_lock.h"
#include "run/loss_advice.h"
#include "run/opened_dataset.h"
#include "run/output_checks.h"
#include "run/recording_examination.h"
#include "run/recording_identity.h"
#include "run/run_output.h"
#include "run/run_report.h"
#include "run/settings.h"
#include "run/slam_arguments.h"
#include "run/slam_run.h"
#include "view/live_view.h"

namespace highwall::apps {
namespace {

void WarnOfImu(const SlamRun& run) {
  if (!run.inertial) return;
  if (run.inertial->initialized) {
    if (run.inertial->given_up == 0) return;
    fmt::print(stderr, "highwall slam: warning: the IMU was not used for {} frames: {}\n",
               run.inertial->given_up, run.inertial->given_up_because);
    return;
  }
  fmt::print(
      stderr, "highwall slam: warning: the IMU was not used: {}\n",
      run.inertial->last.reason.empty() ? "it was never initialized" : run.inertial->last.reason);
}

void WarnOfGps(const SlamRun& run) {
  if (!run.gps || run.gps->T_GW) return;
  fmt::print(stderr,
             "highwall slam: warning: the GPS was not used: {} of its {} fixes belong to tracked "
             "frames, too few or too close together to locate the map in the frame of the GPS\n",
             run.gps->used, run.gps->fixes);
}

// The scale of the depth by the IMU means nothing while the clocks are not aligned, or if the
// images contradict the IMU.
bool IsDepthScaleKnown(const SlamRun& run) {
  constexpr double kSettled = 3e-3;  // [s] sigma of t_d
  const auto is_of_imu = [](const SensorFinding& finding) {
    return finding.fault >= SensorFault::kImuMount &&
           finding.fault <= SensorFault::kImuInconsistent;
  };
  return run.inertial && run.inertial->depth_scale &&
         run.inertial->last.status != InertialStatus::kGivenUp &&
         run.inertial->last.time_offset_sigma < kSettled &&
         std::ranges::none_of(run.verdict.findings, is_of_imu);
}

// Significant, and larger than the calibration error of most depth cameras.
void WarnOfDepth(const SlamRun& run, double depth_factor) {
  if (!IsDepthScaleKnown(run)) return;
  const DepthScale& depth = *run.inertial->depth_scale;
  const double off = std::abs(depth.scale - 1.0);
  if (off <= 0.01 || off <= 3.0 * depth.sigma) return;
  fmt::print(stderr,
             "highwall slam: warning: depth reads {:.1f} % too {}: set depth_factor: {:.5g} in "
             "calibration.yaml\n",
             100.0 * std::abs(1.0 / depth.scale - 1.0), depth.scale < 1.0 ? "long" : "short",
             depth_factor / depth.scale);
}

void PrintInertial(const InertialSummary& inertial) {
  if (!inertial.last.estimate) return;
  const InertialReport& last = inertial.last;
  fmt::print(
      "imu         t_d {:.2f} +- {:.2f} ms, gravity +- {:.2f} deg, {} frames by the IMU alone\n",
      last.time_offset * 1e3, last.time_offset_sigma * 1e3, last.gravity_sigma * 180.0 / M_PI,
      inertial.dead_reckoned);
  if (inertial.contradicted > 0 || inertial.saturated > 0) {
    fmt::print("            images contradict {} intervals, {} intervals saturate the sensor\n",
               inertial.contradicted, inertial.saturated);
  }
  if (const auto& mount = last.extrinsics) {
    const Eigen::Vector3d p = 1e3 * mount->T_BC.p(), s = 1e3 * mount->lever_arm_sigma;
    fmt::print(
        "camera at   {:.1f} {:.1f} {:.1f} mm in the IMU's frame, +- {:.1f} {:.1f} {:.1f} mm\n",
        p.x(), p.y(), p.z(), s.x(), s.y(), s.z());
  }
  if (const auto& depth = inertial.depth_scale) {
    fmt::print("depth       scale {:.4f} +- {:.4f} (true depth = scale x measured)\n", depth->scale,
               depth->sigma);
  }
}

void PrintMapping(const SlamRun& run) {
  fmt::print("map         {} keyframes, {} points, {} lines\n", run.keyframes.size(), run.points,
             run.lines);
  if (!run.sensor.depth_pattern.IsZero()) {
    fmt::print("depth       correction of the distortion over the image: {:.2f} % at 1 m (RMS)\n",
               100.0 * run.sensor.depth_pattern.Rms());
  }
  if (run.inertial) PrintInertial(*run.inertial);
  if (run.gps && run.gps->T_GW) {
    fmt::print("gps         {} of {} fixes used, {:.2f} m RMS from the trajectory\n", run.gps->used,
               run.gps->fixes, run.gps->rms);
  }
  fmt::print("loops       {} closed, {} rejected\n", run.loops.closed, run.loops.refused);
  const AdjustmentCounts& adjusted = run.adjustments;
  fmt::print(
      "adjustments {} of the map; {} rejected, {} failed, {} without effect; {} steps rejected\n",
      adjusted.all, adjusted.refused, adjusted.failed, adjusted.unmoved, adjusted.rejected_steps);
  fmt::print("mapping     {:.1f} ms a keyframe (median)\n", run.times.mapping.median);
}

void PrintLive(const SlamRun& run) {
  const TimingStatistics& delay = run.times.delay;
  fmt::print(
      "live        {} frames dropped; poses {:.1f} ms after their images (median), "
      "99 % within {:.1f}\n",
      run.dropped, delay.median, delay.p99);
  const PostponedWork& postponed = run.postponed;
  if (postponed.keyframes + postponed.loop_searches == 0) return;
  fmt::print("postponed   keyframes in {} frames; loops were not searched for {} keyframes\n",
             postponed.keyframes, postponed.loop_searches);
}

void PrintSubmaps(const SlamRun& run) {
  if (!run.map_met) {
    fmt::print(
        "map         no frame was recognized in the loaded map; {} is in a world of its own\n",
        NameOfSubmap(kTrajectoryFile, FirstPlace(run)));
  }
  if (run.loops.merges > 0) fmt::print("merges      {} of submaps\n", run.loops.merges);
  if (run.others.empty()) return;
  const std::size_t first = FirstPlace(run);
  std::string parts = fmt::format("{} frames in {}", run.largest.trajectory.size(),
                                  NameOfSubmap(kTrajectoryFile, first));
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    parts += fmt::format(", {} in {}", run.others[i].trajectory.size(),
                         NameOfSubmap(kTrajectoryFile, first + i + 1));
  }
  fmt::print("submaps     {} separate worlds: {}\n", run.others.size() + 1, parts);
}

// Prints how to measure the accuracy, or how to judge it without a ground truth.
void PrintAccuracy(const SlamRun& run, const SlamArguments& arguments, bool has_truth) {
  const auto truth = std::filesystem::path(arguments.dataset) / "groundtruth.txt";
  if (has_truth && std::filesystem::exists(truth)) {
    const auto trajectory =
        std::filesystem::path(arguments.out) / NameOfSubmap(kTrajectoryFile, FirstPlace(run));
    fmt::print("accuracy    highwall eval ape {} {}\n", truth.string(), trajectory.string());
  } else if (!has_truth) {
    fmt::print(
        "accuracy    unknown: the recording has no ground truth. Judge it by closed loops, by "
        "double walls in the cloud, and by a second recording (highwall map compare)\n");
  }
}

// has_truth: a readable ground truth exists. memory: as in run.json [MiB].
void PrintSummary(const SlamRun& run, const SlamArguments& arguments, bool has_truth,
                  double memory) {
  fmt::print("frames      {} ({} lost, {} skipped, {} relocalizations)\n", run.frames,
             run.lost.size(), run.skipped, run.relocalizations);
  fmt::print("coverage    {:.2f} % of the {} colour images of the recording have a pose{}\n",
             100.0 * ColourCoverage(run), CountColourImages(run),
             run.without_depth == 0
                 ? ""
                 : fmt::format("; {} have no depth image in time", run.without_depth));
  if (const std::string advice = LossAdvice(run.loss_reasons, run.lost.size()); !advice.empty()) {
    fmt::print("lost        {}\n", advice);
  }
  if (run.repeated > 0) fmt::print("repeated    {} colour images\n", run.repeated);
  PrintSubmaps(run);
  if (run.open_frames > 0) {
    fmt::print("degenerate  {} frames leave a direction of the pose unobservable\n",
               run.open_frames);
  }
  if (arguments.live) PrintLive(run);
  if (arguments.localize) {
    fmt::print("map         {} points, {} lines, not changed\n", run.points, run.lines);
  } else {
    PrintMapping(run);
  }
  fmt::print("tracking    {:.1f} ms a frame (median), 95 % within {:.1f} ms\n",
             run.times.tracking.median, run.times.tracking.p95);
  const TimingStatistics& frame = run.times.frame;
  fmt::print(
      "frame       {:.1f} ms (median), 95 % within {:.1f}, 99 % within {:.1f}, all within {:.1f}\n",
      frame.median, frame.p95, frame.p99, frame.worst);
  fmt::print("processor   {:.1f} s, {:.1f} ms a frame without decoding ({:.1f} s)\n",
             run.processor.process, ProcessorMsPerFrame(run), run.processor.decoding);
  if (const auto& dense = run.largest.dense) {
    fmt::print("dense map   {} points, {} octree nodes at {} m\n", dense->cloud.size(),
               dense->octree.NodeCount(), dense->octree.options().resolution);
  }
  fmt::print("memory      {:.0f} MiB at its peak\n", memory);
  PrintAccuracy(run, arguments, has_truth);
  fmt::print("results in  {}\n", arguments.out);
  fmt::print("verdict     {}\n", run.verdict.Summary());
}

// Rejects an octree resolution that is too fine early, from the memory of a single image.
void RequireMemory(const Dataset& dataset, const PinholeCamera& camera,
                   const OctomapBuilderOptions& octree) {
  constexpr double kLimit = 200.0;  // [MB] of one image: a map contains the content of tens of them
  constexpr std::size_t kImages = 4;
  const DepthUnprojector unprojector(camera);
  for (std::size_t i = 0; i < kImages; ++i) {
    const auto image = dataset.Load(i * dataset.size() / kImages);
    if (!image) continue;
    const DepthView view{image->depth, Pose()};
    const double megabytes = PredictOctreeBytes({&view, 1}, unprojector, octree) / 1e6;
    if (megabytes <= kLimit) continue;
    throw InvalidArgument(fmt::format(
        "an octree of {} m would take about {:.0f} MB for a single image, more than the limit of "
        "{:.0f} MB: choose a coarser --resolution or --no-map",
        octree.resolution, megabytes, kLimit));
  }
}

// What stopped a run, and its progress. The button of the page counts as Ctrl-C.
struct Stopped {
  int signal = SIGINT;
  std::string by = "the page";
  std::size_t done = 0, frames = 0;
};

std::optional<Stopped> StoppedBy(const StopSignals& signals, const SlamRun& run) {
  if (run.left == 0) return std::nullopt;
  Stopped stopped;
  if (const int signal = signals.caught(); signal != 0) {
    stopped.signal = signal;
    stopped.by = SignalName(signal);
  }
  stopped.done = run.frames + run.skipped + run.dropped;
  stopped.frames = stopped.done + run.left;
  return stopped;
}

void PrintStopped(const Stopped& stopped, const char* then) {
  fmt::print(stderr, "highwall slam: stopped by {} after {} of {} frames: {}\n", stopped.by,
             stopped.done, stopped.frames, then);
}

// Returns the live view of a run and prints its address; null without --view. signals: outlives it.
std::unique_ptr<LiveView> OpenView(const SlamArguments& arguments, const RgbdSensor& sensor,
                                   const SlamRunOptions& options, const StopSignals& signals) {
  if (arguments.view.empty()) return nullptr;
  DenseMapOptions shown = options.map;
  LimitToRange(sensor, &shown);
  LiveViewOptions view{.address = arguments.view_address,
                       .port = std::stoi(arguments.view),
                       .title = ToUtf8(arguments.out),
                       .min_depth = shown.cloud.min_depth,
                       .max_depth = shown.cloud.max_depth,
                       .save_to = {},
                       .interrupted = [&signals] { return signals.caught() != 0; }};
  for (const std::filesystem::path& path : {options.keep_map, options.save_map}) {
    if (!path.empty()) view.save_to.push_back(path);
  }
  auto opened = std::make_unique<LiveView>(sensor, std::move(view));
  fmt::print(stderr, "highwall slam: the run can be seen at {}\n", opened->url());
  return opened;
}

// Writes report.html if it is requested, from the current content of the folder, and shows it to
// the clients of the view; returns false if it could not be written.
bool ShowReport(const SlamArguments& arguments, LiveView* view) {
  constexpr std::chrono::seconds kReportTimeout(10);  // for clients to fetch it
  const bool watched = view != nullptr && view->clients() > 0;
  if (!arguments.report && !watched) return true;
  const std::filesystem::path folder = arguments.out;
  std::string page;
  try {
    page = HtmlReport(std::span(&folder, 1));
    if (arguments.report) WriteHtml(folder / kReportPage, page);
  } catch (const std::exception& error) {
    fmt::print(stderr, "highwall slam: {}\n", OneLine(error.what()));
    return !arguments.report;
  }
  if (arguments.report && !HasView3d()) {
    fmt::print(stderr, "highwall slam: warning: report.html has no 3-D view: {}\n", kNoView3d);
  }
  if (watched) view->End(std::move(page), kReportTimeout);
  return true;
}

// The files of the run that made the map are deleted when another run uses its folder.
void RequireMapElsewhere(const SlamArguments& arguments) {
  namespace fs = std::filesystem;
  if (arguments.overwrite || arguments.load_map.empty()) return;
  std::error_code error;
  const fs::path out = arguments.out, map = fs::absolute(arguments.load_map, error);
  const auto is_in_out = [&](const fs::path& file) {
    return fs::equivalent(file.parent_path(), out, error);
  };
  if (!is_in_out(map) && !is_in_out(fs::canonical(map, error)) &&
      !fs::equivalent(map, out / kMapFile, error)) {
    return;
  }
  throw IoError(arguments.load_map,
                "is in the folder of --out, where this run would replace the one that made the "
                "map: choose another --out, or give --overwrite");
}

int RunSlamCommand(const SlamArguments& arguments) {
  if (arguments.print_settings) {
    fmt::print("{}", SettingsFile(MakeOptions(arguments).slam));
    return kExitOk;
  }
  RequireRunFolder(arguments.out, arguments.overwrite);
  RequireMapElsewhere(arguments);
  if (!arguments.save_map.empty()) RequireFile(arguments.save_map);
  if (!arguments.trace.empty()) RequireFile(arguments.trace);
  const FolderLock lock(arguments.out);
  const OpenedDataset opened = OpenWithConfig(
      arguments.config, arguments.dataset,
      {.max_stamp_difference = arguments.max_pair_difference, .frame_rate = arguments.frame_rate});
  const RgbdSensor& sensor = opened.config.sensor;
  const Dataset& dataset = *opened.images;
  for (const std::string& warning : dataset.warnings()) {
    fmt::print(stderr, "highwall slam: warning: {}\n", warning);
  }
  SlamRunOptions options = MakeOptions(arguments);
  if (options.dense) RequireMemory(dataset, sensor.camera, options.map.octree);
  if (arguments.deterministic) cv::setNumThreads(1);  // same result, but single-threaded
  std::vector<std::string> warnings;
  options.before = ExamineRecording(dataset, sensor, options.begin, options.end);
  for (const SensorFinding& finding : options.before.findings) {
    fmt::print(stderr, "highwall slam: warning: {}\n", Line(finding));
  }
  options.imu = ReadImuFeed(arguments, opened, &warnings, &options.before);
  options.gps = ReadGpsFeed(arguments, opened, options.imu.has_value());
  for (const std::string& warning : warnings) {
    fmt::print(stderr, "highwall slam: warning: {}\n", warning);
  }
  RunOutput output(arguments.out, arguments.save_map, arguments.load_map);
  if (arguments.covariances) output.KeepCovariances();
  if (!arguments.localize) options.keep_map = std::filesystem::path(arguments.out) / kMapFile;
  const StopSignals signals;
  const std::unique_ptr<LiveView> view = OpenView(arguments, sensor, options, signals);
  options.observer = view.get();
  options.stop = [&] { return signals.caught() != 0 || (view && view->stopped()); };
  SlamRun run;
  {
    Progress progress("tracking");
    run = RunSlam(
        dataset, sensor, options,
        {.on_frame =
             [&](const FrameResult& result, const RgbdImage&, std::size_t done, std::size_t total) {
               output.Follow(result);
               progress.Update(done, total);
             },
         .on_tracked =
             [&](const SlamRun& tracked) {
               progress.Begin("finishing the maps");
               if (view) view->Begin("finishing the maps");
               output.WriteTrajectories(tracked);
             },
         .on_finding =
             [&](const SensorFinding& finding) {
               progress.Print("highwall slam: warning: " + Line(finding));
             }});
  }
  for (const Dataset::Problem& problem : dataset.problems()) {
    fmt::print(stderr, "highwall slam: skipped frame {}: {}\n", problem.frame,
               OneLine(problem.what));
  }
  WarnOfImu(run);
  WarnOfDepth(run, sensor.depth_factor);
  WarnOfGps(run);
  const std::optional<Stopped> stopped = StoppedBy(signals, run);
  if (stopped && run.largest.trajectory.empty()) {
    PrintStopped(*stopped, "no frame had a pose, and nothing is written");
    return ExitCodeOf(stopped->signal);
  }
  if (run.largest.trajectory.empty() && !arguments.load_map.empty()) {
    throw IoError(arguments.load_map, "no frame was recognized in this map");
  }
  if (run.largest.trajectory.empty()) {
    const std::string advice = LossAdvice(run.loss_reasons, run.lost.size());
    throw IoError(arguments.dataset,
                  "no frame could be tracked: too little texture or depth to start a map (see "
                  "highwall info)" +
                      (advice.empty() ? "" : "; " + advice));
  }
  nlohmann::json report = RunJson(run, options, arguments.dataset, opened.origin);
  report["recording"] = ToJson(IdentityOf(dataset));
  report["max_pair_difference_s"] = arguments.max_pair_difference;
  report["frame_rate_hz"] = arguments.frame_rate;
  report["depth_noise"] = ToJson(sensor.depth_noise);
  report["settings"] = ChangedSettings(options.slam);
  if (stopped) {
    report["stopped"] = {{"signal", SignalName(stopped->signal)},
                         {"frames_done", stopped->done},
                         {"frames", stopped->frames}};
  }
  {
    const Progress progress("writing the results");
    report = output.WriteRest(run, report);
  }
  if (arguments.json) {
    fmt::print("{}\n", JsonText(report));
  } else {
    PrintSummary(run, arguments, dataset.groundtruth() != nullptr, report["peak_memory_mib"]);
  }
  for (const std::string& failure : output.failures()) {
    fmt::print(stderr, "highwall slam: {}\n", OneLine(failure));
  }
  const bool has_page = ShowReport(arguments, view.get());
  if (stopped) {
    PrintStopped(*stopped, "the results are those of these frames");
    return ExitCodeOf(stopped->signal);
  }
  const bool is_strict_failure = arguments.strict && run.verdict.trust() != Trust::kConsistent;
  return output.failures().empty() && has_page && !is_strict_failure ? kExitOk : kExitFailed;
}

}  // namespace

void AddSlamCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<SlamArguments>();
  CLI::App* command =
      app.add_subcommand("slam", "Estimate the trajectory and the map of an RGB-D sequence");
  AddSlamOptions(command, arguments.get());
  command->footer(
      "Example:\n  highwall slam --dataset rgbd_dataset_freiburg1_xyz --config tum1 --out run");
  command->callback([arguments, &action] {
    CheckArguments(*arguments);
    action = [arguments] { return RunSlamCommand(*arguments); };
  });
}

}  // namespace highwall::apps
