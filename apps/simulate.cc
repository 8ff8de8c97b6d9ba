#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "commands.h"
#include "option_checks.h"
#include "progress.h"
#include "simulate/noise_ratio.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/haul_road.h"
#include "simulate/scenes/mine.h"
#include "simulate/scenes/room.h"

namespace highwall::apps {
namespace {

using simulate::ExposureMode;
using simulate::SensorNoise;
using simulate::Simulation;
using simulate::SimulationOptions;

// What is not given depends on the scene.
struct SimulateArguments {
  std::string scene;
  std::string folder;
  std::uint64_t seed = 1;
  double fps = 30.0;
  double scale = 1.0;
  double line_delay = 0.0;   // [us]
  double time_offset = 0.0;  // [s]
  double noise_ratio = simulate::kUsualNoiseRatio;
  std::string imu = "on";
  bool moving = false;
  std::optional<double> duration, rest;
  std::optional<std::string> noise, exposure;
  std::vector<std::string> blackouts;
};

// T:S, both numbers, S positive.
std::optional<simulate::Blackout> ParseBlackout(const std::string& text) {
  const char* begin = text.c_str();
  char* end = nullptr;
  simulate::Blackout blackout;
  blackout.begin = std::strtod(begin, &end);
  if (end == begin || *end != ':' || !(blackout.begin >= 0.0)) return std::nullopt;
  begin = end + 1;
  blackout.duration = std::strtod(begin, &end);
  const bool sound = end != begin && *end == '\0' && blackout.duration > 0.0;
  if (!sound || !std::isfinite(blackout.begin + blackout.duration)) return std::nullopt;
  return blackout;
}

CLI::Validator IsBlackout() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        return ParseBlackout(text) ? "" : "must be BEGIN:DURATION in seconds, is " + text;
      },
      "T:S");
}

double DefaultDuration(const std::string& scene) {
  if (scene == "mine") return 90.0;
  return scene == "road" ? 35.0 : 10.0;
}

SimulationOptions MakeOptions(const SimulateArguments& arguments) {
  SimulationOptions options =
      arguments.scene == "room" ? SimulationOptions() : simulate::FieldTestOptions();
  options.seed = arguments.seed;
  options.fps = arguments.fps;
  options.duration = arguments.duration.value_or(DefaultDuration(arguments.scene));
  options.rest = arguments.rest.value_or(options.rest);
  options.camera = simulate::Scaled(options.camera, arguments.scale);
  options.traffic = arguments.moving;
  options.line_delay = 1e-6 * arguments.line_delay;
  if (arguments.noise) {
    options.sensor.noise = *arguments.noise == "off"      ? SensorNoise::kOff
                           : *arguments.noise == "kinect" ? SensorNoise::kKinect
                                                          : SensorNoise::kD435i;
  }
  const bool ideal = options.sensor.noise == SensorNoise::kOff;
  if (ideal) options.exposure.mode = ExposureMode::kIdeal;
  if (arguments.exposure) {
    options.exposure.mode =
        *arguments.exposure == "auto" ? ExposureMode::kAuto : ExposureMode::kIdeal;
  }
  for (const std::string& text : arguments.blackouts) {
    options.blackouts.push_back(*ParseBlackout(text));
  }
  options.sensor.noise_ratio = options.imu.noise_ratio = arguments.noise_ratio;
  options.imu.ideal = ideal;
  options.imu.enabled = arguments.imu == "on";
  options.imu.time_offset = arguments.time_offset;
  return options;
}

Simulation Simulate(const std::string& scene, const SimulationOptions& options) {
  if (scene == "mine") return simulate::SimulateMine(options);
  if (scene == "road") return simulate::SimulateRoad(options);
  return simulate::SimulateRoom(options);
}

int RunSimulate(const SimulateArguments& arguments) {
  const Simulation simulation = Simulate(arguments.scene, MakeOptions(arguments));
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

void AddCameraOptions(CLI::App* command, SimulateArguments* arguments) {
  command->add_option("--fps", arguments->fps, "Frames per second")
      ->check(Between(0.1, 240.0))
      ->capture_default_str();
  command->add_option("--scale", arguments->scale, "Of the image, 1 = 640 x 480")
      ->check(Between(0.1, 2.0))
      ->capture_default_str();
  command
      ->add_option("--noise", arguments->noise,
                   "Of depth and colour, kinect or d435i; off: of the IMU too "
                   "[default: kinect in the room, d435i elsewhere]")
      ->check(CLI::IsMember({"off", "kinect", "d435i"}));
  command
      ->add_option("--noise-ratio", arguments->noise_ratio,
                   "True noise of depth and IMU over that of the data sheets, which is what "
                   "calibration.yaml says")
      ->check(Between(0.01, 100.0))
      ->capture_default_str();
  command
      ->add_option("--exposure", arguments->exposure,
                   "auto: motion blur, and noise in the dark; off: neither "
                   "[default: off in the room and without noise]")
      ->check(CLI::IsMember({"off", "auto"}));
  command->add_option("--rolling-shutter", arguments->line_delay, "Delay of a row to the next [us]")
      ->check(Between(0.0, 200.0))
      ->capture_default_str();
  command
      ->add_option("--blackout", arguments->blackouts,
                   "Cover the lens at T for S seconds; may be repeated")
      ->check(IsBlackout());
}

void AddImuOptions(CLI::App* command, SimulateArguments* arguments) {
  command->add_option("--imu", arguments->imu, "Write imu.csv and groundtruth_state.csv")
      ->check(CLI::IsMember({"off", "on"}))
      ->capture_default_str();
  command
      ->add_option("--time-offset", arguments->time_offset,
                   "How far the IMU's clock is ahead of the camera's [s]")
      ->check(Between(-0.2, 0.2))
      ->capture_default_str();
}

}  // namespace

void AddSimulateCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand(
      "simulate", "Make an RGB-D-inertial dataset with exact truth, in the TUM layout");
  command->add_option("SCENE", arguments->scene, "The scene: mine, road or room")
      ->required()
      ->check(CLI::IsMember({"mine", "road", "room"}));
  command->add_option("--out", arguments->folder, "Folder to make; it must be absent or empty")
      ->required()
      ->check(NotEmpty());
  command->add_option("--seed", arguments->seed, "Another number, another scene, path and noise")
      ->check(Between(0.0, 4294967295.0))
      ->capture_default_str();
  command
      ->add_option("--duration", arguments->duration,
                   "Length of the sequence [s] [default: mine 90, road 35, room 10]")
      ->check(Between(1e-3, 3600.0));
  command
      ->add_option("--rest", arguments->rest,
                   "How long the camera stands still at first [s] [default: 1, room 0]")
      ->check(Between(0.0, 60.0));
  command->add_flag("--moving", arguments->moving,
                    "Let a worker walk ahead and a truck come along; in the room, "
                    "somebody walk round it");
  AddCameraOptions(command, arguments.get());
  AddImuOptions(command, arguments.get());
  command->footer("Example: highwall simulate mine --out mine --duration 20");
  command->callback(
      [&action, arguments] { action = [arguments] { return RunSimulate(*arguments); }; });
}

}  // namespace highwall::apps
