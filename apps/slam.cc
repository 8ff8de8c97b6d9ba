// highwall slam: a dataset in, trajectory, keyframes, cloud, octree, grid and a report out.
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/tum_dataset.h>
#include <highwall/mapping/octree_size.h>

#include "commands.h"
#include "config.h"
#include "imu_choice.h"
#include "imu_input.h"
#include "option_checks.h"
#include "progress.h"
#include "run_report.h"
#include "slam_run.h"

namespace highwall::apps {
namespace {

enum class Features { kPoints, kLines, kBoth };

struct SlamArguments {
  std::string dataset, config, out, load_map, save_map;
  Features features = Features::kBoth;
  LineDetector detector = LineExtractorOptions().detector;
  Weighting weighting = MeasurementOptions().weighting;
  MadRule mad_rule = LineMatcherOptions().mad_rule;
  double resolution = OctomapBuilderOptions().resolution;
  std::string imu;  // --imu as given
  bool moving_objects = true;
  bool deterministic = false;
  bool live = false;
  bool no_map = false;
  bool no_loops = false;
  bool adjust_all = false;
  bool localize = false;
  bool json = false;
};

SlamRunOptions MakeOptions(const SlamArguments& arguments) {
  SlamRunOptions options;
  options.slam.frame.use_points = arguments.features != Features::kLines;
  options.slam.frame.use_lines = arguments.features != Features::kPoints;
  options.slam.frame.lines.detector = arguments.detector;
  options.slam.measurement.weighting = arguments.weighting;
  options.slam.tracker.matcher.lines.mad_rule = arguments.mad_rule;
  options.slam.tracker.relocalizer.lines.mad_rule = arguments.mad_rule;
  options.slam.mapper.matcher.lines.mad_rule = arguments.mad_rule;
  options.slam.tracker.moving.enabled = arguments.moving_objects;
  options.map.octree.resolution = arguments.resolution;
  // The dense map is made of the keyframes of the run: where there are none there is none.
  options.dense = !arguments.no_map && !arguments.localize;
  options.slam.localize_only = arguments.localize;
  options.slam.loops.enabled = !arguments.no_loops && !arguments.localize;
  options.adjust_all = arguments.adjust_all;
  options.load_map = arguments.load_map;
  options.save_map = arguments.save_map;
  options.live = arguments.live;
  if (arguments.deterministic) {
    options.slam = Deterministic(options.slam);
    options.prefetch = 0;
    options.map.background = false;
  }
  return options;
}

// The readings of the dataset's IMU where it has one, it can be used and the user wants it.
std::optional<ImuFeed> MakeImuFeed(const TumDataset& dataset, const RunConfig& config,
                                   bool required) {
  std::optional<ImuInput> input = LoadImu(dataset, config.imu);
  if (!input) {
    if (required) {
      throw IoError(dataset.directory(), "has no IMU (imu.csv), but --imu asks for one");
    }
    return std::nullopt;
  }
  for (const std::string& warning : input->warnings) {
    fmt::print(stderr, "highwall slam: warning: {}\n", warning);
  }
  if (!input->IsUsable()) return std::nullopt;
  return ImuFeed{input->calibration, std::move(input->samples)};
}

void WarnOfImu(const SlamRun& run) {
  if (!run.inertial || run.inertial->initialized) return;
  fmt::print(
      stderr, "highwall slam: warning: the IMU was not used: {}\n",
      run.inertial->last.reason.empty() ? "it was never initialized" : run.inertial->last.reason);
}

// Beyond doubt, and more than the calibration of most depth cameras leaves.
void WarnOfDepth(const SlamRun& run, double depth_factor) {
  if (!run.inertial || !run.inertial->depth_scale) return;
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
  fmt::print("imu         t_d {:.2f} +- {:.2f} ms, gravity +- {:.2f} deg, {} frames by it alone\n",
             last.time_offset * 1e3, last.time_offset_sigma * 1e3,
             last.gravity_sigma * 180.0 / M_PI, inertial.dead_reckoned);
  if (const auto& depth = inertial.depth_scale) {
    fmt::print("depth       scale {:.4f} +- {:.4f} (true depth = scale x measured)\n", depth->scale,
               depth->sigma);
  }
}

void PrintMapping(const SlamRun& run) {
  fmt::print("map         {} keyframes, {} points, {} lines\n", run.keyframes.size(), run.points,
             run.lines);
  if (run.inertial) PrintInertial(*run.inertial);
  fmt::print("loops       {} closed, {} refused\n", run.loops.closed, run.loops.refused);
  fmt::print("mapping     {:.1f} ms a keyframe (median)\n", run.times.mapping.median);
}

void PrintSummary(const SlamRun& run, const TumDataset& dataset, const SlamArguments& arguments) {
  fmt::print("frames      {} ({} lost, {} skipped, {} relocalizations)\n", run.frames,
             run.lost.size(), run.skipped, run.relocalizations);
  if (run.open_frames > 0) {
    fmt::print("open        {} frames leave a direction of the pose open\n", run.open_frames);
  }
  if (arguments.live) fmt::print("live        {} frames dropped\n", run.dropped);
  if (arguments.localize) {
    fmt::print("map         {} points, {} lines, as they were\n", run.points, run.lines);
  } else {
    PrintMapping(run);
  }
  fmt::print("tracking    {:.1f} ms a frame (median), 95 % within {:.1f} ms\n",
             run.times.tracking.median, run.times.tracking.p95);
  if (run.dense) {
    fmt::print("dense map   {} points, {} octree nodes at {} m\n", run.dense->cloud.size(),
               run.dense->octree.NodeCount(), run.dense->octree.options().resolution);
  }
  fmt::print("memory      {:.0f} MiB at its peak\n", PeakMemoryMib());
  if (dataset.groundtruth() != nullptr) {
    fmt::print("error       highwall eval ape {} {}\n",
               (dataset.directory() / "groundtruth.txt").string(),
               (std::filesystem::path(arguments.out) / "trajectory.txt").string());
  }
  fmt::print("results in  {}\n", arguments.out);
}

// Before the work, not after it: a folder that can be written, or made where it is absent.
void RequireFolder(const std::filesystem::path& out) {
  std::error_code error;
  if (std::filesystem::is_directory(out, error)) {
    if (::access(out.c_str(), W_OK | X_OK) != 0) throw IoError(out, "cannot be written to");
    return;
  }
  if (std::filesystem::exists(std::filesystem::symlink_status(out, error))) {
    throw IoError(out, "is a file, but --out needs a folder");
  }
  std::filesystem::path above = std::filesystem::absolute(out, error).parent_path();
  while (above.has_relative_path() && !std::filesystem::exists(above, error)) {
    above = above.parent_path();
  }
  if (!std::filesystem::is_directory(above, error) || ::access(above.c_str(), W_OK | X_OK) != 0) {
    throw IoError(out, "cannot be made: no folder can be made in " + above.string());
  }
}

// The same for a file.
void RequireFile(const std::filesystem::path& file) {
  RequireFolder(std::filesystem::absolute(file).parent_path());
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    throw IoError(file, "is not a file");
  }
}

// An octree that is too fine is refused at once, by what a single image would take of it.
void RequireMemory(const TumDataset& dataset, const PinholeCamera& camera,
                   const OctomapBuilderOptions& octree) {
  constexpr double kLimit = 200.0;  // [MB] of one image: a map holds what tens of them show
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

int RunSlamCommand(const SlamArguments& arguments) {
  RequireFolder(arguments.out);
  if (!arguments.save_map.empty()) RequireFile(arguments.save_map);
  const ResolvedConfig resolved = ResolveConfig(arguments.config, arguments.dataset);
  const RgbdSensor& sensor = resolved.config.sensor;
  const TumDataset dataset(arguments.dataset, {.depth_factor = sensor.depth_factor,
                                               .width = sensor.camera.width,
                                               .height = sensor.camera.height});
  for (const std::string& warning : dataset.warnings()) {
    fmt::print(stderr, "highwall slam: warning: {}\n", warning);
  }
  SlamRunOptions options = MakeOptions(arguments);
  if (options.dense) RequireMemory(dataset, sensor.camera, options.map.octree);
  if (arguments.deterministic) cv::setNumThreads(1);  // the same result, but on one thread as said
  if (const auto weighting = ReadImuChoice(arguments.imu); weighting && !arguments.localize) {
    options.slam.inertial.weighting = *weighting;
    options.imu = MakeImuFeed(dataset, resolved.config, !arguments.imu.empty());
  }
  SlamRun run;
  {
    Progress progress("tracking");
    run = RunSlam(dataset, sensor, options,
                  [&](const FrameResult&, const RgbdImage&, std::size_t done, std::size_t total) {
                    progress.Update(done, total);
                  });
  }
  for (const Dataset::Problem& problem : dataset.problems()) {
    fmt::print(stderr, "highwall slam: skipped frame {}: {}\n", problem.frame, problem.what);
  }
  WarnOfImu(run);
  WarnOfDepth(run, sensor.depth_factor);
  if (run.trajectory.empty() && !arguments.load_map.empty()) {
    throw IoError(arguments.load_map, "no frame was recognized in this map");
  }
  if (run.trajectory.empty()) {
    throw IoError(arguments.dataset,
                  "no frame could be tracked: too little texture or depth to start a map (see "
                  "highwall info)");
  }
  const nlohmann::json report =
      WriteRun(arguments.out, run, RunJson(run, options, arguments.dataset, resolved.origin));
  if (arguments.json) {
    fmt::print("{}\n", report.dump());
  } else {
    PrintSummary(run, dataset, arguments);
  }
  return kExitOk;
}

// What a run does with a map: go on in one, keep it, localize in it.
void AddMapOptions(CLI::App* command, SlamArguments* arguments) {
  CLI::Option* load_map = command->add_option("--load-map", arguments->load_map,
                                              "Go on in a map that --save-map wrote");
  CLI::Option* save_map =
      command
          ->add_option("--save-map", arguments->save_map, "Write keyframes and landmarks to a file")
          ->check(NotEmpty());
  CLI::Option* adjust_all =
      command->add_flag("--adjust-all", arguments->adjust_all,
                        "In the end adjust all keyframes and landmarks together, and write "
                        "trajectory_adjusted.txt");
  command
      ->add_flag("--localize", arguments->localize,
                 "The map of --load-map stays as it is: poses in it by images alone, nothing else")
      ->needs(load_map)
      ->excludes(save_map)
      ->excludes(adjust_all);
}

}  // namespace

void AddSlamCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<SlamArguments>();
  CLI::App* command =
      app.add_subcommand("slam", "Estimate the trajectory and the map of an RGB-D sequence");
  command->add_option("--dataset", arguments->dataset, "Folder in the TUM RGB-D layout")
      ->required();
  command->add_option("--config", arguments->config,
                      "tum1, tum2, tum3 or a YAML file (default: calibration.yaml of the dataset, "
                      "else what its name tells)");
  command->add_option("--out", arguments->out, "Folder for the results")
      ->required()
      ->check(NotEmpty());
  command->add_option("--features", arguments->features, "points, lines or both")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Features>{
          {"points", Features::kPoints}, {"lines", Features::kLines}, {"both", Features::kBoth}}));
  command->add_option("--line-detector", arguments->detector, "lsd or edlines")
      ->transform(CLI::CheckedTransformer(std::map<std::string, LineDetector>{
          {"lsd", LineDetector::kLsd}, {"edlines", LineDetector::kEdLines}}));
  command->add_option("--line-outliers", arguments->mad_rule, "median or paper")
      ->transform(CLI::CheckedTransformer(std::map<std::string, MadRule>{
          {"median", MadRule::kMedian}, {"paper", MadRule::kPaper}}));
  command->add_option("--weighting", arguments->weighting, "covariance or paper")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Weighting>{
          {"covariance", Weighting::kCovariance}, {"paper", Weighting::kPaper}}));
  command->add_option("--resolution", arguments->resolution, "Edge of the smallest voxel [m]")
      ->check(Between(1e-3, 10.0))
      ->capture_default_str();
  command
      ->add_option("--imu", arguments->imu,
                   "off, or the weight of its residuals: paper, consistent, fixed:W (default: "
                   "consistent where the dataset has an IMU)")
      ->check(ImuChoice());
  command
      ->add_option("--moving-objects", arguments->moving_objects,
                   "on: what moves is neither tracked nor mapped, or off (default: on)")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}));
  CLI::Option* deterministic =
      command->add_flag("--deterministic", arguments->deterministic,
                        "One thread; the same output, bit for bit, on every run");
  command
      ->add_flag("--live", arguments->live,
                 "At the pace of the stamps; frames that come too fast are dropped and counted")
      ->excludes(deterministic);
  AddMapOptions(command, arguments.get());
  command->add_flag("--no-loops", arguments->no_loops, "Do not close loops");
  command->add_flag("--no-map", arguments->no_map, "No cloud, octree and grid");
  command->add_flag("--json", arguments->json, "Print the report as one JSON object");
  command->footer(
      "Example:\n  highwall slam --dataset rgbd_dataset_freiburg1_xyz --config tum1 --out run");
  command->callback([arguments, &action] {
    if (arguments->localize && !arguments->imu.empty() && ReadImuChoice(arguments->imu)) {
      throw CLI::ValidationError("--localize", "works by images alone: leave --imu out or off");
    }
    action = [arguments] { return RunSlamCommand(*arguments); };
  });
}

}  // namespace highwall::apps
