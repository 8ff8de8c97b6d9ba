// highwall convert: writes a recording in any format as a folder of TUM RGB-D, and the calibration
// of another system as calibration.yaml.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "commands/tum_copy.h"
#include "run/calibration_file.h"
#include "run/foreign_config.h"
#include "run/opened_dataset.h"
#include "run/output_checks.h"

namespace highwall::apps {
namespace {

struct ConvertArguments {
  std::string in, out, config;
  double max_pair_difference = kMaxPairDifference;  // [s]
  double frame_rate = kFrameRate;                   // [Hz]
  BagTopics topics;
};

// A bag is the only recording that is a file.
bool IsCalibration(const std::filesystem::path& in) {
  std::error_code is_none;
  return std::filesystem::is_regular_file(in, is_none) && FindDatasetReader(in) == nullptr;
}

int ConvertCalibration(const ConvertArguments& arguments) {
  if (!arguments.config.empty()) {
    throw IoError(arguments.in, "is a calibration, not a recording: leave --config out");
  }
  std::error_code is_missing;
  if (std::filesystem::equivalent(arguments.in, arguments.out, is_missing)) {
    throw IoError(arguments.out, "is the calibration that is read: choose another file");
  }
  RequireFile(arguments.out);
  const RunConfig config = ReadSensor(arguments.in);
  if (const std::string note = NoteOfDefaults({config, arguments.in}); !note.empty()) {
    fmt::print(stderr, "highwall convert: {}\n", note);
  }
  const bool is_assumed =
      std::ranges::find(config.defaults, "depth_factor") != config.defaults.end();
  WriteConfig(arguments.out, config, {},
              is_assumed ? "assumed: it is not stated by " + config.format : "");
  const PinholeCamera& camera = config.sensor.camera;
  fmt::print("camera      {} x {}, fx {:g}, fy {:g}, cx {:g}, cy {:g}\n", camera.width,
             camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
  if (config.imu) fmt::print("imu         with its pose\n");
  fmt::print("results in  {}\n", arguments.out);
  return kExitOk;
}

int RunConvert(const ConvertArguments& arguments) {
  if (IsCalibration(arguments.in)) return ConvertCalibration(arguments);
  const OpenedDataset recording =
      OpenWithConfig(arguments.config, arguments.in,
                     {.max_stamp_difference = arguments.max_pair_difference,
                      .frame_rate = arguments.frame_rate,
                      .topics = arguments.topics});
  PrintSources("convert", recording);
  for (const std::string& warning : recording.images->warnings()) PrintWarning("convert", warning);
  TumCopy copy;
  {
    Progress progress("writing frames");
    copy = CopyAsTum(
        recording, arguments.in, arguments.out,
        [&progress](std::size_t done, std::size_t total) { progress.Update(done, total); });
  }
  for (const Dataset::Problem& problem : recording.images->problems()) {
    PrintWarning("convert", fmt::format("frame {} is left out: {}", problem.frame, problem.what));
  }
  fmt::print("frames      {} of {}, depth factor {}\n", copy.frames, recording.images->size(),
             copy.depth_factor);
  if (copy.without_confidence > 0) {
    fmt::print(
        "confidence  left out of {} frames: this layout has no place for it, so depth of medium "
        "confidence is given the weight of high confidence\n",
        copy.without_confidence);
  }
  if (copy.poses > 0) fmt::print("poses       {} in groundtruth.txt\n", copy.poses);
  if (copy.readings > 0) fmt::print("imu         {} readings in imu.csv\n", copy.readings);
  fmt::print("results in  {}\n", arguments.out);
  return kExitOk;
}

}  // namespace

void AddConvertCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command =
      app.add_subcommand("convert",
                         "Write a recording in another format as one of TUM RGB-D, or "
                         "a calibration as calibration.yaml");
  command
      ->add_option("IN", arguments->in,
                   "Folder or bag of the recording, in any format that slam reads; or a "
                   "calibration of ORB-SLAM, OpenCV, ROS, Kalibr, EuRoC or Open3D")
      ->required();
  command
      ->add_option("OUT", arguments->out,
                   "Folder to write, which must be empty or not exist; or the calibration file")
      ->required()
      ->check(NotEmpty());
  command->add_option("--config", arguments->config,
                      "tum1, tum2, tum3 or a calibration file (default: as for slam)");
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddFrameRate(command, &arguments->frame_rate);
  AddTopics(command, &arguments->topics);
  command->footer(
      "Examples:\n  highwall convert my_iphone_scan my_scan_tum\n"
      "  highwall convert camchain-imucam.yaml calibration.yaml");
  command->callback(
      [&action, arguments] { action = [arguments] { return RunConvert(*arguments); }; });
}

}  // namespace highwall::apps
