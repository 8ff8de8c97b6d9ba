// highwall demo: simulates a scene, maps it, and evaluates the error, with the commands of a user.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "run/output_checks.h"

namespace highwall::apps {
namespace {

struct DemoArguments {
  std::filesystem::path out = "highwall_demo";
};

// Prints a command as it would be typed, and runs it.
int Show(const std::string& about, const std::vector<std::string>& words) {
  fmt::print("== {}\n$ highwall {}\n", about, fmt::join(words, " "));
  std::fflush(stdout);  // before the command writes to other streams
  const int exit_code = RunCommand(words);
  fmt::print("\n");
  return exit_code;
}

int RunDemo(const DemoArguments& arguments) {
  RequireFolder(arguments.out);
  RequireRunFolder(arguments.out / "run", false);  // before a minute of computation
  std::filesystem::create_directories(arguments.out);
  const std::string mine = (arguments.out / "mine").string();
  const std::string run = (arguments.out / "run").string();
  int exit_code = kExitOk;
  // The dataset is created atomically: an existing one is complete.
  if (!std::filesystem::exists(mine)) {
    exit_code = Show(
        "An open-pit mine as a vehicle sees it: rendered, with the noise of a D435i "
        "and its IMU",
        {"simulate", "mine", "--out", mine, "--duration", "20", "--fps", "20", "--scale", "0.5"});
  }
  if (exit_code == kExitOk) {
    exit_code = Show("SLAM with points, lines and IMU; cloud, octree and grid",
                     {"slam", "--dataset", mine, "--out", run});
  }
  if (exit_code == kExitOk) {
    exit_code = Show("The error against the exact truth",
                     {"eval", "ape", mine + "/groundtruth.txt", run + "/trajectory.txt", "--plot",
                      run + "/error.svg"});
  }
  if (exit_code != kExitOk) return exit_code;
  fmt::print(
      "== Results\n"
      "  {0}                the recording, in the TUM RGB-D layout, with imu.csv\n"
      "  {1}/trajectory.txt  pose of every frame (stamp tx ty tz qx qy qz qw)\n"
      "  {1}/cloud.ply       coloured point cloud\n"
      "  {1}/map.bt          octree, as octovis shows it\n"
      "  {1}/grid.yaml       occupancy grid (grid.pgm), as map_server reads it\n"
      "  {1}/error.svg       the path beside the true one, and its error over time\n"
      "  {1}/run.json        options, versions, times, memory\n"
      "Next: highwall info YOUR_RECORDING says whether it can be used, and with which "
      "calibration.\n",
      mine, run);
  return kExitOk;
}

}  // namespace

void AddDemoCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<DemoArguments>();
  CLI::App* command = app.add_subcommand(
      "demo", "Make a small recording, map it and print the error: a minute or two, offline");
  command
      ->add_option("--out", arguments->out,
                   "Folder of the recording and the results; an existing recording is used")
      ->check(NotEmpty())
      ->capture_default_str();
  command->footer("Example:\n  highwall demo");
  command->callback([arguments, &action] { action = [arguments] { return RunDemo(*arguments); }; });
}

}  // namespace highwall::apps
