#include "slam_arguments.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <map>
#include <utility>

#include <highwall/core/error.h>

#include "imu_choice.h"
#include "imu_input.h"
#include "option_checks.h"

namespace highwall::apps {
namespace {

// What a run does with a map: go on in one, keep it, localize in it.
void AddMapOptions(CLI::App* command, SlamArguments* arguments) {
  CLI::Option* load_map =
      command->add_option("--load-map", arguments->load_map,
                          "Go on in a map: map.hwmap of a run, or what --save-map wrote");
  CLI::Option* save_map =
      command
          ->add_option("--save-map", arguments->save_map,
                       "Write keyframes and landmarks, map.hwmap of the run, to this file as well")
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

void AddSlamOptions(CLI::App* command, SlamArguments* arguments) {
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
  command
      ->add_option("--frame-timing", arguments->frame_timing,
                   "estimated: read-out of the rows and delay of depth are found out, known: they "
                   "are those of the calibration, or ignored (default: estimated)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, FrameTimingMode>{{"estimated", FrameTimingMode::kEstimated},
                                                 {"known", FrameTimingMode::kKnown},
                                                 {"ignored", FrameTimingMode::kIgnored}}));
  CLI::Option* deterministic =
      command->add_flag("--deterministic", arguments->deterministic,
                        "One thread; the same output, bit for bit, on every run");
  command
      ->add_flag("--live", arguments->live,
                 "At the pace of the stamps; frames that come too fast are dropped and counted")
      ->excludes(deterministic);
  AddMapOptions(command, arguments);
  command->add_flag("--no-loops", arguments->no_loops, "Do not close loops");
  command->add_flag("--no-map", arguments->no_map, "No cloud, octree and grid");
  command->add_flag("--report", arguments->report,
                    "Write report.html too: the run on one page, for any browser");
  command->add_flag("--json", arguments->json, "Print the report as one JSON object");
}

void CheckArguments(const SlamArguments& arguments) {
  if (arguments.localize && !arguments.imu.empty() && ReadImuChoice(arguments.imu)) {
    throw CLI::ValidationError("--localize", "works by images alone: leave --imu out or off");
  }
}

bool WantsImu(const SlamArguments& arguments) {
  return ReadImuChoice(arguments.imu).has_value() && !arguments.localize;
}

std::optional<ImuFeed> ReadImuFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   std::vector<std::string>* warnings) {
  if (!WantsImu(arguments)) return std::nullopt;
  std::optional<ImuInput> input = LoadImu(*dataset.images, dataset.config.imu);
  if (!input) {
    if (arguments.imu.empty()) return std::nullopt;
    throw IoError(arguments.dataset, "has no IMU (imu.csv), but --imu asks for one");
  }
  warnings->insert(warnings->end(), input->warnings.begin(), input->warnings.end());
  if (!input->IsUsable()) return std::nullopt;
  return ImuFeed{input->calibration, std::move(input->samples)};
}

SlamRunOptions MakeOptions(const SlamArguments& arguments) {
  SlamRunOptions options;
  options.slam.frame.use_points = arguments.features != Features::kLines;
  options.slam.frame.use_lines = arguments.features != Features::kPoints;
  options.slam.frame.lines.detector = arguments.detector;
  options.slam.measurement.weighting = arguments.weighting;
  options.slam.measurement.line_matches.mad_rule = arguments.mad_rule;
  options.slam.tracker.moving.enabled = arguments.moving_objects;
  options.slam.tracker.timing = arguments.frame_timing;
  options.map.octree.resolution = arguments.resolution;
  // The dense map is made of the keyframes of the run: where there are none there is none.
  options.dense = !arguments.no_map && !arguments.localize;
  options.slam.localize_only = arguments.localize;
  options.slam.loops.enabled = !arguments.no_loops && !arguments.localize;
  options.adjust_all = arguments.adjust_all;
  options.load_map = arguments.load_map;
  options.save_map = arguments.save_map;
  options.live = arguments.live;
  if (const auto weighting = ReadImuChoice(arguments.imu)) {
    options.slam.inertial.weighting = *weighting;
  }
  if (arguments.deterministic) {
    options.slam = Deterministic(options.slam);
    options.prefetch = 0;
    options.map.background = false;
  }
  return options;
}

}  // namespace highwall::apps
