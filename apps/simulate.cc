#include <cstdint>
#include <iostream>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "commands.h"
#include "option_checks.h"
#include "progress.h"
#include "simulate/room.h"
#include "simulate/tum_writer.h"

namespace highwall::apps {
namespace {

struct SimulateArguments {
  std::string scene;
  std::string folder;
  std::string noise = "kinect";
  std::string imu = "on";
  simulate::SimulationOptions options;
};

int RunSimulate(const SimulateArguments& arguments) {
  simulate::SimulationOptions options = arguments.options;
  options.sensor.noise =
      arguments.noise == "off" ? simulate::SensorNoise::kOff : simulate::SensorNoise::kKinect;
  options.imu.ideal = arguments.noise == "off";
  options.imu.enabled = arguments.imu == "on";
  const simulate::Simulation simulation = simulate::SimulateRoom(options);
  {
    Progress progress("rendering");
    simulate::WriteTum(simulation, arguments.folder, [&progress](int done, int total) {
      progress.Update(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
    });
  }
  std::cout << simulation.size() << " frames of the " << arguments.scene << " in "
            << arguments.folder << "\n";
  return kExitOk;
}

}  // namespace

void AddSimulateCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<SimulateArguments>();
  simulate::SimulationOptions& options = arguments->options;
  CLI::App* command =
      app.add_subcommand("simulate", "Make an RGB-D dataset with exact truth, in the TUM layout");
  command->add_option("SCENE", arguments->scene, "What to film: room")
      ->required()
      ->check(CLI::IsMember({"room"}));
  command->add_option("--out", arguments->folder, "Folder to make; it must be absent or empty")
      ->required()
      ->check(NotEmpty());
  command->add_option("--seed", options.seed, "Another number, another room, path and noise")
      ->check(Between(0.0, 4294967295.0))
      ->capture_default_str();
  command->add_option("--duration", options.duration, "Length of the sequence [s]")
      ->check(Between(1e-3, 3600.0))
      ->capture_default_str();
  command->add_option("--fps", options.fps, "Frames per second")
      ->check(Between(0.1, 240.0))
      ->capture_default_str();
  command->add_option("--rest", options.rest, "How long the camera stands still at first [s]")
      ->check(Between(0.0, 60.0))
      ->capture_default_str();
  command->add_option("--noise", arguments->noise, "Of depth and colour; off: of the IMU too")
      ->check(CLI::IsMember({"off", "kinect"}))
      ->capture_default_str();
  command->add_option("--imu", arguments->imu, "Write imu.csv and groundtruth_state.csv")
      ->check(CLI::IsMember({"off", "on"}))
      ->capture_default_str();
  command
      ->add_option("--time-offset", options.imu.time_offset,
                   "How far the IMU's clock is ahead of the camera's [s]")
      ->check(Between(-0.2, 0.2))
      ->capture_default_str();
  command->footer("Example: highwall simulate room --out room --duration 10");
  command->callback(
      [&action, arguments] { action = [arguments] { return RunSimulate(*arguments); }; });
}

}  // namespace highwall::apps
