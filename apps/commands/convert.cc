// highwall convert: writes a recording in any format as a folder of TUM RGB-D.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>

#include <fmt/core.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "commands/tum_copy.h"
#include "run/opened_dataset.h"

namespace highwall::apps {
namespace {

struct ConvertArguments {
  std::string in, out, config;
  double max_pair_difference = kMaxPairDifference;  // [s]
  double frame_rate = kFrameRate;                   // [Hz]
  BagTopics topics;
};

int RunConvert(const ConvertArguments& arguments) {
  const OpenedDataset recording =
      OpenWithConfig(arguments.config, arguments.in,
                     {.max_stamp_difference = arguments.max_pair_difference,
                      .frame_rate = arguments.frame_rate,
                      .topics = arguments.topics});
  PrintTopics("convert", *recording.images);
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
  if (copy.poses > 0) fmt::print("poses       {} in groundtruth.txt\n", copy.poses);
  if (copy.readings > 0) fmt::print("imu         {} readings in imu.csv\n", copy.readings);
  fmt::print("results in  {}\n", arguments.out);
  return kExitOk;
}

}  // namespace

void AddConvertCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command =
      app.add_subcommand("convert", "Write a recording in another format as one of TUM RGB-D");
  command
      ->add_option("IN", arguments->in,
                   "Folder or bag of the recording, in any format that slam reads")
      ->required();
  command->add_option("OUT", arguments->out, "Folder to write; it must be empty or not exist")
      ->required()
      ->check(NotEmpty());
  command->add_option("--config", arguments->config,
                      "tum1, tum2, tum3 or a YAML file (default: as for slam)");
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddFrameRate(command, &arguments->frame_rate);
  AddTopics(command, &arguments->topics);
  command->footer("Example:\n  highwall convert my_iphone_scan my_scan_tum");
  command->callback(
      [&action, arguments] { action = [arguments] { return RunConvert(*arguments); }; });
}

}  // namespace highwall::apps
