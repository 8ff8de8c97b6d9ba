// The highwall executable: selects the subcommand and converts exceptions to exit codes.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "cli/classic_locale.h"
#include "cli/commands.h"
#include "cli/usage_error.h"
#include "run/process_memory.h"

namespace highwall::apps {
namespace {

int RunAction(const CommandAction& action, const std::string& command) {
  try {
    return action();
  } catch (const IoError& error) {
    fmt::print(stderr, "{}: {}\n", command, OneLine(error.what()));
    return kExitData;
  } catch (const InvalidArgument& error) {
    fmt::print(stderr, "{}: {}\n", command, OneLine(error.what()));
    return kExitData;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: failed: {}\n", command, OneLine(error.what()));
    return kExitFailed;
  }
}

// Introduction for new users.
constexpr const char* kFirst =
    "highwall: RGB-D-inertial SLAM with points and lines, and the tools around it. To begin:\n"
    "  highwall demo                               makes a recording, maps it, reports the error\n"
    "  highwall info RECORDING                     what yours holds, and whether it can be used\n"
    "  highwall slam --dataset RECORDING --out run\n"
    "  highwall eval ape TRUTH run/trajectory.txt  its error, where the truth is known\n"
    "  highwall --help                             all commands\n";

void AddCommands(CLI::App& app, CommandAction& action) {
  AddSlamCommand(app, action);
  AddCalibrateCommand(app, action);
  AddConvertCommand(app, action);
  AddDemoCommand(app, action);
  AddEvalCommand(app, action);
  AddImuNoiseCommand(app, action);
  AddInfoCommand(app, action);
  AddLiveCommand(app, action);
  AddMapCommand(app, action);
  AddMergeCommand(app, action);
  AddPosegraphCommand(app, action);
  AddReportCommand(app, action);
  AddSimulateCommand(app, action);
}

}  // namespace

void PrintWarning(const std::string& command, const std::string& text) {
  fmt::print(stderr, "highwall {}: warning: {}\n", command, OneLine(text));
}

int RunCommand(std::vector<std::string> words) {
  std::optional<ClassicLocale> classic(std::in_place);
  CLI::App app("RGB-D-inertial SLAM with points and lines, and the tools around it.", "highwall");
  app.set_version_flag("--version", "highwall " HIGHWALL_VERSION);
  app.require_subcommand(0, 1);
  app.failure_message(
      [&app](const CLI::App*, const CLI::Error& error) { return UsageError(app, error); });
  CommandAction action;
  AddCommands(app, action);
  std::ranges::reverse(words);  // the order that CLI11 expects
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;  // --help and --version arrive here too
  }
  classic.reset();
  if (!action) {
    fmt::print(stderr, "{}", kFirst);
    return kExitUsage;
  }
  return RunAction(action, CommandName(app));
}

}  // namespace highwall::apps

int main(int argc, char** argv) {
  highwall::apps::LimitHeaps();
  return highwall::apps::RunCommand({argv + std::min(argc, 1), argv + argc});
}
