// highwall report: one HTML page of a finished run, or of several side by side.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "files/trajectory_input.h"
#include "report/html_report.h"
#include "run/finished_run.h"
#include "run/output_checks.h"
#include "run/recording_identity.h"
#include "run/run_dataset.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

struct ReportArguments {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out, truth;
};

// The page has no errors of a run whose dataset is another recording by now.
void WarnOfOtherRecordings(const ReportArguments& arguments) {
  for (const std::filesystem::path& run : arguments.runs) {
    const nlohmann::json report = ReadReport(run);
    const std::vector<std::filesystem::path> datasets = DatasetsOfRun(run, report);
    if (datasets.size() != 1) continue;
    const std::string difference = DifferenceFromRun(datasets.front(), report);
    if (difference.empty()) continue;
    PrintWarning("report", datasets.front().string() + " is another recording than that of " +
                               run.string() + ": it " + difference +
                               "; its ground truth is not used");
  }
}

int RunReport(const ReportArguments& arguments) {
  const std::filesystem::path out =
      !arguments.out.empty() ? arguments.out : arguments.runs.front() / kReportPage;
  RequireFile(out);
  RunDataOptions options;
  if (!arguments.truth.empty()) {
    options.truth = arguments.truth;
    // The page reads the file itself; this call only prints the assumptions.
    ReadStampedPoses("report", arguments.truth);
  }
  if (arguments.truth.empty()) WarnOfOtherRecordings(arguments);
  WriteHtml(out, HtmlReport(arguments.runs, options));
  fmt::print("report      {} ({:.1f} MB)\n", out.string(),
             static_cast<double>(std::filesystem::file_size(out)) / 1e6);
  if (!HasView3d()) fmt::print("3-D view    none: {}\n", kNoView3d);
  return kExitOk;
}

}  // namespace

void AddReportCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand(
      "report", "One HTML page of a finished run, or of several side by side, for any browser");
  command->add_option("run", arguments->runs, "Folder of highwall slam --out")
      ->required()
      ->check(NotEmpty());
  CLI::Option* out = command
                         ->add_option("--out", arguments->out,
                                      "File to write [report.html in the folder of a single run]")
                         ->check(NotEmpty());
  command
      ->add_option("--groundtruth", arguments->truth,
                   "Poses of the camera to measure errors against [groundtruth.txt of the dataset]")
      ->check(NotEmpty());
  command->footer(
      "Example:\n  highwall report run\n  highwall report run_a run_b --out compared.html");
  command->callback([arguments, out, &action] {
    if (arguments->runs.size() > 1 && out->count() == 0) {
      throw CLI::RequiredError("--out, where several runs are given,");
    }
    action = [arguments] { return RunReport(*arguments); };
  });
}

}  // namespace highwall::apps
