#include "run/slam_arguments.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/system/option_table.h>

#include "cli/option_checks.h"
#include "run/imu_choice.h"
#include "run/imu_input.h"
#include "run/output_checks.h"
#include "run/settings.h"

namespace highwall::apps {
namespace {

// Adds the options for loading, saving and localizing in a map.
void AddMapOptions(CLI::App* command, SlamArguments* arguments) {
  CLI::Option* load_map =
      command->add_option("--load-map", arguments->load_map,
                          "Continue in a map: map.hwmap of a run, or a file of --save-map");
  CLI::Option* save_map =
      command
          ->add_option("--save-map", arguments->save_map,
                       "Write keyframes and landmarks, map.hwmap of the run, to this file as well")
          ->check(NotEmpty());
  CLI::Option* adjust_all =
      command->add_flag("--adjust-all", arguments->adjust_all,
                        "Adjust all keyframes and landmarks together at the end, and write "
                        "trajectory_adjusted.txt");
  command
      ->add_flag(
          "--localize", arguments->localize,
          "Only estimate poses in the map of --load-map, from images alone; it is not changed")
      ->needs(load_map)
      ->excludes(save_map)
      ->excludes(adjust_all);
}

// Applies the given switches.
void ApplySwitches(const SlamArguments& arguments, SlamOptions* slam) {
  if (arguments.features) {
    slam->frame.use_points = arguments.features != Features::kLines;
    slam->frame.use_lines = arguments.features != Features::kPoints;
  }
  const auto apply = [](const auto& given, auto* value) {
    if (given) *value = *given;
  };
  apply(arguments.point_detector, &slam->frame.point_detector);
  apply(arguments.detector, &slam->frame.lines.detector);
  apply(arguments.weighting, &slam->measurement.weighting);
  apply(arguments.mad_rule, &slam->measurement.mad_rule);
  apply(arguments.moving_objects, &slam->tracker.moving.enabled);
  apply(arguments.frame_timing, &slam->tracker.timing);
  if (!arguments.imu.empty()) apply(ReadImuChoice(arguments.imu), &slam->inertial.weighting);
  if (arguments.no_loops || arguments.localize) slam->loops.enabled = false;
  if (arguments.localize) slam->localize_only = true;
}

void AddOutputOptions(CLI::App* command, SlamArguments* arguments) {
  command
      ->add_option("--trace", arguments->trace,
                   "Write the stages of each thread to this file, for chrome://tracing and "
                   "ui.perfetto.dev")
      ->check(NotEmpty());
  command->add_flag("--memory-report", arguments->memory_report,
                    "Show who holds the memory at the end of the run");
  command->add_flag("--covariances", arguments->covariances,
                    "Write covariances_causal.txt too: how uncertain each pose was when its frame "
                    "was tracked");
  command->add_flag("--report", arguments->report,
                    "Write report.html too: the run on one page, for any browser");
  CLI::Option* view =
      command
          ->add_flag("--view{8080}", arguments->view,
                     "Show the run while it lasts, in any browser: --view=PORT (default: 8080, 0: "
                     "any free port)")
          ->type_name("PORT")
          ->check(CLI::Range(0, 65535));
  command
      ->add_option("--view-address", arguments->view_address,
                   "Serve that page on this address, to whoever knows its token")
      ->check(NotEmpty())
      ->needs(view)
      ->capture_default_str();
  command->add_flag("--overwrite", arguments->overwrite, kOverwriteHelp);
  command->add_flag("--json", arguments->json, "Print the report as one JSON object");
  command->add_flag("--strict", arguments->strict,
                    "Exit with 3 unless the recording and its configuration are consistent");
}

// unneeded: options that are not required for --print-settings.
void AddSettings(CLI::App* command, SlamArguments* arguments,
                 const std::vector<CLI::Option*>& unneeded) {
  command->add_option("--settings", arguments->settings,
                      "YAML file of settings, as --print-settings writes it");
  command
      ->add_option("--set", arguments->set,
                   "One setting, such as tracker.min_support=25; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(CLI::Validator(
          [](const std::string& setting) -> std::string {
            SlamOptions options;
            try {
              Set(setting, &options);
            } catch (const InvalidArgument& error) {
              return error.what();
            }
            return "";
          },
          ""));
  command->add_flag_callback(
      "--print-settings",
      [arguments, unneeded] {
        arguments->print_settings = true;
        for (CLI::Option* option : unneeded) option->required(false);
      },
      "Print all settings as YAML, with units and ranges, and exit");
}

}  // namespace

void AddSlamOptions(CLI::App* command, SlamArguments* arguments) {
  CLI::Option* dataset = command
                             ->add_option("--dataset,DATASET", arguments->dataset,
                                          "Folder or bag of the recording: TUM RGB-D, EuRoC, ROS "
                                          "and others")
                             ->required();
  command->add_option(
      "--config", arguments->config,
      "tum1, tum2, tum3 or a calibration file (default: calibration.yaml of the dataset, "
      "else the preset that its name gives)");
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddFrameRate(command, &arguments->frame_rate);
  AddTopics(command, &arguments->topics);
  AddChoice<bool>(command, "--gps", &arguments->gps, {{"on", true}, {"off", false}},
                  "on: the fixes of gps.csv keep the map from drifting, where the dataset has them "
                  "(default: on)");
  CLI::Option* deterministic =
      command->add_flag("--deterministic", arguments->deterministic,
                        "One thread; the same output, bit for bit, on every run");
  command
      ->add_flag("--live", arguments->live,
                 "At the pace of the stamps; frames that come too fast are dropped and counted")
      ->excludes(deterministic);
  AddRunOptions(command, arguments, {dataset});
}

void AddRunOptions(CLI::App* command, SlamArguments* arguments,
                   std::vector<CLI::Option*> unneeded) {
  unneeded.push_back(command->add_option("--out", arguments->out, "Folder for the results")
                         ->required()
                         ->check(NotEmpty()));
  AddSettings(command, arguments, unneeded);
  AddChoice<Features>(
      command, "--features", &arguments->features,
      {{"points", Features::kPoints}, {"lines", Features::kLines}, {"both", Features::kBoth}},
      "Features that are tracked (default: both)");
  AddChoice(command, "--point-detector", &arguments->point_detector,
            Named<PointDetector>(kChoices<PointDetector>), "Detector of points (default: orb)");
  AddChoice(command, "--line-detector", &arguments->detector,
            Named<LineDetector>(kChoices<LineDetector>), "Detector of lines (default: edlines)");
  AddChoice(command, "--line-outliers", &arguments->mad_rule, Named<MadRule>(kChoices<MadRule>),
            "How false matches of lines are rejected (default: median)");
  AddChoice(command, "--weighting", &arguments->weighting, Named<Weighting>(kChoices<Weighting>),
            "Weights of observations with depth (default: covariance)");
  command->add_option("--resolution", arguments->resolution, "Edge of the smallest voxel [m]")
      ->check(Between(1e-3, 10.0))
      ->capture_default_str();
  command
      ->add_option("--imu", arguments->imu,
                   "off, or the weight of its residuals: paper, fixed:W (default: 1 where there is "
                   "an IMU, less while it contradicts the images)")
      ->check(ImuChoice());
  AddChoice<bool>(command, "--moving-objects", &arguments->moving_objects,
                  {{"on", true}, {"off", false}},
                  "on: dynamic objects are masked out of tracking and mapping (default: on)");
  AddChoice(
      command, "--frame-timing", &arguments->frame_timing,
      Named<FrameTimingMode>(kChoices<FrameTimingMode>),
      "estimated: the readout of the rows and the delay of depth are estimated online, known: "
      "they are those of the calibration (default: estimated)");
  AddMapOptions(command, arguments);
  command->add_flag("--no-loops", arguments->no_loops, "Do not close loops");
  command->add_flag("--no-map", arguments->no_map, "No cloud, octree and grid");
  AddOutputOptions(command, arguments);
}

void CheckArguments(const SlamArguments& arguments) {
  if (arguments.localize && !arguments.imu.empty() && ReadImuChoice(arguments.imu)) {
    throw CLI::ValidationError("--localize", "works by images alone: leave --imu out or off");
  }
  if (!arguments.settings.empty()) return;  // errors of the file are not usage errors
  try {
    MakeOptions(arguments);
  } catch (const InvalidArgument& error) {
    throw CLI::ValidationError("--set", error.what());
  }
}

bool WantsImu(const SlamArguments& arguments) {
  return ReadImuChoice(arguments.imu).has_value() && !arguments.localize;
}

std::optional<ImuFeed> ReadImuFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   std::vector<std::string>* warnings, SensorVerdict* verdict) {
  if (!WantsImu(arguments)) return std::nullopt;
  const auto refuse = [&](SensorFault fault, const std::string& reason) {
    verdict->Add({fault, Trust::kDoubtful, reason,
                  "the images are used alone; highwall info lists the faults of the readings"});
  };
  std::optional<ImuInput> input;
  try {
    input = LoadImu(*dataset.images, dataset.config.imu);
  } catch (const IoError& error) {  // the images can still be tracked
    if (!arguments.imu.empty()) throw;
    warnings->push_back(std::string(error.what()) + "; the IMU is not used");
    refuse(SensorFault::kImuReadings, "the file of the IMU cannot be read");
    return std::nullopt;
  }
  if (!input) {
    if (arguments.imu.empty()) return std::nullopt;
    throw IoError(arguments.dataset, "has no IMU (imu.csv), but --imu asks for one");
  }
  warnings->insert(warnings->end(), input->warnings.begin(), input->warnings.end());
  if (!input->IsUsable()) {
    const ImuFinding& finding =
        *std::ranges::find(input->findings, ImuSeverity::kFatal, &ImuFinding::severity);
    refuse(FaultOf(finding.kind), "the readings of the IMU cannot be used: " + finding.text);
    return std::nullopt;
  }
  return ImuFeed{input->calibration, std::move(input->samples)};
}

std::optional<GpsFeed> ReadGpsFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   bool with_imu) {
  if (!arguments.gps || arguments.localize) return std::nullopt;
  return LoadGps(arguments.dataset, dataset.config, with_imu);
}

SlamRunOptions MakeOptions(const SlamArguments& arguments) {
  SlamRunOptions options;
  if (!arguments.settings.empty()) ReadSettings(arguments.settings, &options.slam);
  ApplySwitches(arguments, &options.slam);
  for (const std::string& setting : arguments.set) Set(setting, &options.slam);
  CheckSettings(options.slam);
  HIGHWALL_REQUIRE(options.slam.localize_only == arguments.localize,
                   "localize_only needs a map: give --load-map and --localize instead");
  options.map.octree.resolution = arguments.resolution;
  // The dense map is built from the keyframes of the run; localization has none.
  options.dense = !arguments.no_map && !arguments.localize;
  options.adjust_all = arguments.adjust_all;
  options.load_map = arguments.load_map;
  options.save_map = arguments.save_map;
  options.trace = arguments.trace;
  options.live = arguments.live;
  if (arguments.deterministic) {
    options.slam = Deterministic(options.slam);
    options.prefetch = 0;
    options.map.background = false;
  }
  return options;
}

}  // namespace highwall::apps
