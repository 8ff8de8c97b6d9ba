#include <iostream>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "commands/dataset_report.h"
#include "run/opened_dataset.h"

namespace highwall::apps {
namespace {

struct InfoArguments {
  std::string directory;
  double max_pair_difference = kMaxPairDifference;  // [s]
  double frame_rate = kFrameRate;                   // [Hz]
  BagTopics topics;
  bool json = false;
};

int RunInfo(const InfoArguments& arguments) {
  DatasetReport report;
  {
    Progress progress("reading frames");
    report = InspectDataset(
        arguments.directory,
        {.max_stamp_difference = arguments.max_pair_difference,
         .frame_rate = arguments.frame_rate,
         .topics = arguments.topics},
        [&progress](std::size_t done, std::size_t total) { progress.Update(done, total); });
  }
  std::cout << (arguments.json ? ToJson(report) + "\n" : ToText(report));
  return kExitOk;
}

}  // namespace

void AddInfoCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command =
      app.add_subcommand("info", "Describe a dataset, its faults and the calibration that fits");
  command
      ->add_option("DIR", arguments->directory,
                   "Folder or bag of the recording: TUM RGB-D and others")
      ->required();
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddFrameRate(command, &arguments->frame_rate);
  AddTopics(command, &arguments->topics);
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->footer("Example:\n  highwall info rgbd_dataset_freiburg1_xyz");
  command->callback([&action, arguments] { action = [arguments] { return RunInfo(*arguments); }; });
}

}  // namespace highwall::apps
