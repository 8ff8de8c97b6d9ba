#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "dataset_report.h"
#include "progress.h"

namespace highwall {
namespace {

struct InfoArguments {
  std::string directory;
  bool json = false;
};

void RunInfo(const InfoArguments& arguments) {
  DatasetReport report;
  {
    Progress progress("reading frames");
    report = InspectDataset(arguments.directory, [&progress](std::size_t done, std::size_t total) {
      progress.Update(done, total);
    });
  }
  std::cout << (arguments.json ? ToJson(report) + "\n" : ToText(report));
}

}  // namespace

void AddInfoCommand(CLI::App& app) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand(
      "info", "Say what a dataset holds, what is wrong with it and which calibration fits");
  command->add_option("DIR", arguments->directory, "Folder with rgb.txt and depth.txt (TUM RGB-D)")
      ->required();
  command->add_flag("--json", arguments->json, "Print one JSON object");
  command->footer("Example: highwall info rgbd_dataset_freiburg1_xyz");
  command->callback([arguments] { RunInfo(*arguments); });
}

}  // namespace highwall
