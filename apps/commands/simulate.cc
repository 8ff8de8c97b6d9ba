#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/imu_check.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/internal/number_text.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/trajectory_input.h"
#include "simulate/motion/recorded_motion.h"
#include "simulate/noise_ratio.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/drive.h"
#include "simulate/scenes/haul_road.h"
#include "simulate/scenes/mine.h"
#include "simulate/scenes/recorded_room.h"
#include "simulate/scenes/room.h"

namespace highwall::apps {
namespace {

using simulate::ExposureMode;
using simulate::SensorNoise;
using simulate::Simulation;
using simulate::SimulationOptions;

constexpr double kLongestSimulation = 3600.0;  // [s]

// Defaults of absent options depend on the scene.
struct SimulateArguments {
  std::string scene;
  std::string folder;
  std::uint64_t seed = 1;
  double fps = 30.0;
  double scale = 1.0;
  std::string camera;                         // a calibration.yaml; empty: that of the scene
  std::optional<double> line_delay;           // [us]
  double readout = 0.0, depth_readout = 0.0;  // [s]
  double depth_delay = 0.0;                   // [s]
  double depth_bias = 0.0;                    // at 3 m
  double depth_pattern = 0.0;                 // likewise
  bool write_errors = false;
  bool portrait = false;
  double time_offset = 0.0;  // [s]
  double noise_ratio = simulate::kUsualNoiseRatio;
  std::string imu = "on";  // off, on, or a file
  std::filesystem::path trajectory;
  std::vector<double> imu_noise;
  std::string imu_faults = "off";                   // ParseImuFaults
  double gps_rate = 0.0;                            // [Hz] 0: none
  double gps_noise = simulate::GpsOptions().sigma;  // [m]
  bool moving = false;
  std::optional<double> duration, rest;
  std::optional<std::string> noise, exposure;
  std::vector<std::string> blackouts;
};

// Parses T:S, two numbers with positive S.
std::optional<simulate::Blackout> ParseBlackout(const std::string& text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const auto begin = ReadNumber<double>(std::string_view(text).substr(0, colon));
  const auto duration =
      ReadNumber<double>(std::string_view(text).substr(std::min(colon + 1, text.size())));
  if (!begin || !duration || !(*begin >= 0.0 && *duration > 0.0)) return std::nullopt;
  if (!std::isfinite(*begin + *duration)) return std::nullopt;
  return simulate::Blackout{*begin, *duration};
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
  if (scene == "drive") return 60.0;
  return scene == "road" ? 35.0 : 10.0;
}

ImuNoise NoiseOf(const std::vector<double>& densities) {
  return {densities[0], densities[1], densities[2], densities[3]};
}

CLI::Validator AreImuFaults() {
  return {[](std::string& text) -> std::string {
            try {
              simulate::ParseImuFaults(text);
              return "";
            } catch (const InvalidArgument& error) {
              return error.what();
            }
          },
          ""};
}

SimulationOptions MakeOptions(const SimulateArguments& arguments) {
  SimulationOptions options =
      arguments.scene == "room" ? SimulationOptions() : simulate::FieldTestOptions();
  options.seed = arguments.seed;
  options.fps = arguments.fps;
  options.duration = arguments.duration.value_or(DefaultDuration(arguments.scene));
  options.rest = arguments.rest.value_or(options.rest);
  if (!arguments.camera.empty()) {
    const RgbdSensor sensor = ReadSensor(arguments.camera).sensor;
    options.camera = sensor.camera;
    if (const auto& depth = sensor.depth_camera) {
      options.depth_camera = {simulate::Scaled(depth->camera, arguments.scale), depth->T_CD};
    }
  }
  options.camera = simulate::Scaled(options.camera, arguments.scale);
  options.traffic = arguments.moving;
  options.readout = arguments.readout;
  options.depth_readout = arguments.depth_readout;
  if (arguments.line_delay) {
    options.readout = options.depth_readout = 1e-6 * *arguments.line_delay * options.camera.height;
  }
  options.depth_delay = arguments.depth_delay;
  options.sensor.depth_bias = arguments.depth_bias;
  options.sensor.depth_pattern = arguments.depth_pattern;
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
  options.imu.enabled = arguments.imu != "off";
  if (!arguments.trajectory.empty()) {
    options.duration = arguments.duration.value_or(kLongestSimulation);
    options.imu.noise = ImuNoise();
    if (!arguments.imu_noise.empty()) options.imu.noise = NoiseOf(arguments.imu_noise);
  }
  options.imu.faults = simulate::ParseImuFaults(arguments.imu_faults);
  options.imu.time_offset = arguments.time_offset;
  return options;
}

bool IsFile(const std::string& imu) {
  return imu != "on" && imu != "off";
}

simulate::RecordedMotion FitMotion(const SimulateArguments& arguments) {
  const Trajectory captured = ReadStampedPoses("simulate", arguments.trajectory);
  if (captured.empty()) throw IoError(arguments.trajectory, "holds no pose");
  const ImuRecording recording =
      ReadImu(arguments.imu, {captured.front().stamp, captured.back().stamp});
  if (!recording.warning.empty()) PrintWarning("simulate", recording.warning);
  const auto findings =
      CheckImu(recording.samples, {captured.front().stamp, captured.back().stamp});
  for (const ImuFinding& finding : findings) {
    if (finding.severity == ImuSeverity::kFatal) throw IoError(arguments.imu, finding.text);
    PrintWarning("simulate", arguments.imu + ": " + finding.text);
  }
  const auto samples = RepairImu(recording.samples, findings);
  simulate::RecordedMotionOptions options;
  if (!arguments.imu_noise.empty()) options.noise = NoiseOf(arguments.imu_noise);
  try {
    return simulate::FitRecordedMotion(captured, samples, options);
  } catch (const InvalidArgument& error) {
    throw IoError(arguments.trajectory,
                  "and " + arguments.imu + " make no motion: " + error.what());
  }
}

Simulation Simulate(const SimulateArguments& arguments, const SimulationOptions& options) {
  if (!arguments.trajectory.empty()) {
    const simulate::RecordedMotion motion = FitMotion(arguments);
    const simulate::MotionConsistency& median = motion.consistency;
    fmt::print(
        "motion and captured poses differ by {:.1f} mm and {:.2f} deg, and from the readings by "
        "{:.4f} rad/s and {:.3f} m/s^2 (medians)\n",
        1e3 * median.position, median.orientation * 180.0 / std::numbers::pi, median.gyroscope,
        median.accelerometer);
    return simulate::SimulateRecordedRoom(motion, options);
  }
  if (arguments.scene == "mine") return simulate::SimulateMine(options);
  if (arguments.scene == "road") return simulate::SimulateRoad(options);
  if (arguments.scene == "drive") return simulate::SimulateDrive(options);
  return simulate::SimulateRoom(options);
}

simulate::TumOptions MakeTumOptions(const SimulateArguments& arguments) {
  simulate::TumOptions options{.errors = arguments.write_errors, .portrait = arguments.portrait};
  if (arguments.gps_rate > 0.0) {
    options.gps = simulate::GpsOptions{.rate = arguments.gps_rate, .sigma = arguments.gps_noise};
  }
  return options;
}

int RunSimulate(const SimulateArguments& arguments) {
  const Simulation simulation = Simulate(arguments, MakeOptions(arguments));
  {
    Progress progress("rendering");
    simulate::WriteTum(
        simulation, arguments.folder,
        [&progress](int done, int total) {
          progress.Update(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
        },
        MakeTumOptions(arguments));
  }
  fmt::print("{} frames of the {} in {}\n", simulation.size(), arguments.scene, arguments.folder);
  return kExitOk;
}

void AddCameraOptions(CLI::App* command, SimulateArguments* arguments) {
  command->add_option("--fps", arguments->fps, "Frames per second")
      ->check(Between(0.1, 240.0))
      ->capture_default_str();
  command->add_option("--scale", arguments->scale, "Of the image, 1 = 640 x 480")
      ->check(Between(0.1, 2.0))
      ->capture_default_str();
  command->add_option("--camera", arguments->camera,
                      "A calibration.yaml, whose camera takes the images: size, focal lengths, lens; "
                      "its depth_camera, if any, takes those of depth");
  command->add_flag("--portrait", arguments->portrait,
                    "Store the images turned clockwise by a quarter, as a phone held upright does");
  command
      ->add_option("--noise", arguments->noise,
                   "Of depth and colour, kinect or d435i; off: of the IMU too "
                   "[default: kinect in the room, d435i elsewhere]")
      ->check(OneOf({"off", "kinect", "d435i"}));
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
      ->check(OneOf({"off", "auto"}));
  command
      ->add_option("--blackout", arguments->blackouts,
                   "Cover the lens at T for S seconds; may be repeated")
      ->check(IsBlackout());
}

// Adds options for timing and depth errors of low-cost depth cameras.
void AddDepthCameraOptions(CLI::App* command, SimulateArguments* arguments) {
  const auto add = [command](const char* name, double* value, const char* what, double min,
                             double max) {
    return command->add_option(name, *value, what)->check(Between(min, max))->capture_default_str();
  };
  CLI::Option* readout = add("--readout", &arguments->readout,
                             "Time from the first row of colour to the last [s]", 0.0, 1.0);
  CLI::Option* depth_readout = add("--depth-readout", &arguments->depth_readout,
                                   "Time from the first row of depth to the last [s]", 0.0, 1.0);
  command
      ->add_option("--rolling-shutter", arguments->line_delay,
                   "Both, as the time from one row to the next [us]")
      ->check(Between(0.0, 200.0))
      ->excludes(readout, depth_readout);
  add("--depth-delay", &arguments->depth_delay, "How much later than its stamp depth is taken [s]",
      -0.2, 0.2);
  add("--depth-bias", &arguments->depth_bias,
      "Share by which depth reads too long at 3 m; it grows with depth", -0.1, 0.1);
  add("--depth-pattern", &arguments->depth_pattern,
      "By how much more of itself depth reads too long in the image's corners than in its middle, "
      "at "
      "3 m",
      -0.1, 0.1);
  command->add_flag("--write-errors", arguments->write_errors,
                    "Tell read-outs, delay, bias and pattern in calibration.yaml");
}

void AddImuOptions(CLI::App* command, SimulateArguments* arguments) {
  command
      ->add_option("--imu", arguments->imu,
                   "Write imu.csv and groundtruth_state.csv: on or off; with --trajectory the file "
                   "of the recorded readings")
      ->capture_default_str();
  command->add_option("--trajectory", arguments->trajectory,
                      "Film the room along this motion of the IMU, recorded with the readings of "
                      "--imu (TUM: stamp tx ty tz qx qy qz qw)");
  command
      ->add_option("--imu-noise", arguments->imu_noise,
                   "Densities of gyroscope, accelerometer and their walks that belong to recorded "
                   "readings [default: those of EuRoC's ADIS16448]")
      ->delimiter(',')
      ->expected(4)
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--imu-faults", arguments->imu_faults,
                   "Faults of the sensor beside noise, unknown to its calibration: off, hard, or "
                   "hard,name=value,... (docs/simulator.md)")
      ->check(AreImuFaults())
      ->capture_default_str();
  command
      ->add_option("--time-offset", arguments->time_offset,
                   "How far the IMU's clock is ahead of the camera's [s]")
      ->check(Between(-0.2, 0.2))
      ->capture_default_str();
}

void AddGpsOptions(CLI::App* command, SimulateArguments* arguments) {
  CLI::Option* rate =
      command
          ->add_option("--gps", arguments->gps_rate, "Write gps.csv, with so many fixes a second")
          ->check(Between(0.01, 100.0))
          ->excludes("--portrait");
  command
      ->add_option("--gps-noise", arguments->gps_noise,
                   "Sigma of a fix east and north [m]; up it is twice that")
      ->check(Between(1e-4, 100.0))
      ->needs(rate)
      ->capture_default_str();
}

// The read-out of an image must end before the next one begins.
void CheckReadouts(const SimulateArguments& arguments) {
  const SimulationOptions options = MakeOptions(arguments);
  const auto check = [interval = 1.0 / options.fps](const char* name, double readout) {
    if (readout <= interval) return;
    throw CLI::ValidationError(
        name,
        fmt::format("must not take longer than the {:.4g} s from frame to frame, takes {:.4g} s",
                    interval, readout));
  };
  check(arguments.line_delay ? "--rolling-shutter" : "--readout", options.readout);
  check("--depth-readout", options.depth_readout);
}

// A recorded motion requires its IMU readings and the room without --rest and --moving; --imu-noise
// is valid only with it.
void CheckRecorded(const SimulateArguments& arguments) {
  const bool recorded = !arguments.trajectory.empty();
  if (recorded != IsFile(arguments.imu)) {
    throw CLI::ValidationError(
        "--imu", recorded ? "must be the file with the readings that belong to --trajectory"
                          : "must be on or off without --trajectory, is " + arguments.imu);
  }
  if (!recorded && !arguments.imu_noise.empty()) {
    throw CLI::ValidationError("--imu-noise", "belongs to --trajectory");
  }
  if (recorded && (arguments.scene != "room" || arguments.rest || arguments.moving)) {
    throw CLI::ValidationError("--trajectory", "films the room, without --rest and --moving");
  }
}

}  // namespace

void AddSimulateCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand(
      "simulate", "Make an RGB-D-inertial dataset with exact truth, in the TUM layout");
  command->add_option("SCENE", arguments->scene, "The scene: mine, road, drive or room")
      ->required()
      ->check(OneOf({"mine", "road", "drive", "room"}));
  command->add_option("--out", arguments->folder, "Folder to make; it must be absent or empty")
      ->required()
      ->check(NotEmpty());
  command->add_option("--seed", arguments->seed, "Another number, another scene, path and noise")
      ->check(Between(0.0, 4294967295.0))
      ->capture_default_str();
  command
      ->add_option(
          "--duration", arguments->duration,
          "Length of the sequence [s] [default: mine 90, road 35, drive 60, room 10, all of a "
          "recorded motion]")
      ->check(Between(1e-3, kLongestSimulation));
  command
      ->add_option("--rest", arguments->rest,
                   "How long the camera stands still at first [s] [default: 1, room 0]")
      ->check(Between(0.0, 60.0));
  command->add_flag("--moving", arguments->moving,
                    "Let a worker walk ahead and a truck come along; in the room, "
                    "somebody walk round it");
  AddCameraOptions(command, arguments.get());
  AddDepthCameraOptions(command, arguments.get());
  AddImuOptions(command, arguments.get());
  AddGpsOptions(command, arguments.get());
  command->footer("Example: highwall simulate mine --out mine --duration 20");
  command->callback([&action, arguments] {
    CheckRecorded(*arguments);
    CheckReadouts(*arguments);
    action = [arguments] { return RunSimulate(*arguments); };
  });
}

}  // namespace highwall::apps
