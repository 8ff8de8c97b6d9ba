// highwall slam: estimates trajectory and map of a dataset and writes the results and a report.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include <highwall/core/error.h>
#include <highwall/mapping/octree_size.h>

#include "cli/commands.h"
#include "commands/run_summary.h"
#include "commands/slam_session.h"
#include "run/opened_dataset.h"
#include "run/recording_examination.h"
#include "run/recording_identity.h"
#include "run/run_report.h"
#include "run/settings.h"
#include "run/slam_arguments.h"
#include "run/slam_run.h"

namespace highwall::apps {
namespace {

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

int RunSlamCommand(const SlamArguments& arguments) {
  if (arguments.print_settings) {
    fmt::print("{}", SettingsFile(MakeOptions(arguments).slam));
    return kExitOk;
  }
  SlamSession session("slam", arguments);
  const OpenedDataset opened =
      OpenWithConfig(arguments.config, arguments.dataset,
                     {.max_stamp_difference = arguments.max_pair_difference,
                      .frame_rate = arguments.frame_rate,
                      .topics = arguments.topics});
  const RgbdSensor& sensor = opened.config.sensor;
  const Dataset& dataset = *opened.images;
  PrintSources("slam", opened);
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
  session.Begin(sensor, &options);
  const SlamRun run = session.Track(
      [&](const RunCallbacks& callbacks) { return RunSlam(dataset, sensor, options, callbacks); });
  for (const Dataset::Problem& problem : dataset.problems()) {
    fmt::print(stderr, "highwall slam: skipped frame {}: {}\n", problem.frame,
               OneLine(problem.what));
  }
  WarnOfSensors("slam", run, sensor.depth_factor);
  if (const auto exit_code = session.EndWithoutPose(run, arguments.dataset)) return *exit_code;
  nlohmann::json report = RunJson(run, options, arguments.dataset, opened.origin);
  report["recording"] = ToJson(IdentityOf(dataset));
  report["max_pair_difference_s"] = arguments.max_pair_difference;
  report["frame_rate_hz"] = arguments.frame_rate;
  if (const std::string topics = ToText(dataset.topics()); !topics.empty()) {
    report["topics"] = topics;
  }
  report["depth_noise"] = ToJson(sensor.depth_noise);
  report["settings"] = ChangedSettings(options.slam);
  return session.Write(run, std::move(report), dataset.groundtruth() != nullptr);
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
