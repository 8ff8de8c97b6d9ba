// The highwall executable: chooses the subcommand, turns exceptions into exit codes.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "commands.h"

namespace highwall::apps {
namespace {

// "highwall eval", or "highwall" where no subcommand was recognised.
std::string CommandName(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? "highwall" : "highwall " + chosen.front()->get_name();
}

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

int Main(int argc, char** argv) {
  CLI::App app("RGB-D-inertial SLAM with points and lines, and the tools around it.", "highwall");
  app.set_version_flag("--version", "highwall " HIGHWALL_VERSION);
  app.require_subcommand(0, 1);
  app.failure_message([&app](const CLI::App*, const CLI::Error& error) {
    const std::string command = CommandName(app);
    return fmt::format("{}: {} (see {} --help)\n", command, error.what(), command);
  });

  CommandAction action;
  AddSlamCommand(app, action);
  AddCalibrateCommand(app, action);
  AddEvalCommand(app, action);
  AddImuNoiseCommand(app, action);
  AddInfoCommand(app, action);
  AddMapCommand(app, action);
  AddMergeCommand(app, action);
  AddPosegraphCommand(app, action);
  AddReportCommand(app, action);
  AddSimulateCommand(app, action);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;  // --help and --version arrive here too
  }
  if (!action) {
    fmt::print(stderr, "{}", app.help());
    return kExitUsage;
  }
  return RunAction(action, CommandName(app));
}

}  // namespace
}  // namespace highwall::apps

int main(int argc, char** argv) {
  return highwall::apps::Main(argc, argv);
}
