// highwall live: estimates trajectory and map while a camera delivers images.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/live_camera.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/internal/stopwatch.h>

#include "cameras/no_camera.h"
#include "cameras/openni2_camera.h"
#include "cameras/tum_recorder.h"
#include "cli/commands.h"
#include "cli/watch.h"
#include "commands/run_summary.h"
#include "commands/slam_session.h"
#include "run/config.h"
#include "run/live_arguments.h"
#include "run/recording_identity.h"
#include "run/run_report.h"
#include "run/settings.h"

namespace highwall::apps {
namespace {

constexpr double kImuLead = 0.05;  // [s] readings after an image that it waits for

int ListCameras() {
  for (const ConnectedCamera& camera : ListOpenNi2Cameras()) {
    fmt::print("openni2:{}  {}\n", OneLine(camera.uri), OneLine(camera.name));
  }
  return kExitOk;
}

// A camera with the calibration of the run.
struct OpenedCamera {
  std::unique_ptr<ImageSource> images;
  std::string origin;  // human-readable source of the calibration
};

OpenedCamera OpenCamera(const LiveArguments& arguments) {
  const std::string device = ReadCameraChoice(arguments.camera).device;
  const std::string& config = arguments.slam.config;
  if (config.empty()) return {OpenOpenNi2Camera(device, {}), "the camera"};
  ResolvedConfig resolved;
  std::unique_ptr<ImageSource> images = OpenOpenNi2Camera(device, [&](const cv::Size& usual) {
    resolved = ResolveCameraConfig(config, usual);
    return resolved.config;
  });
  if (!resolved.note.empty()) fmt::print(stderr, "highwall live: {}\n", resolved.note);
  return {std::move(images), std::move(resolved.origin)};
}

// The readings arrive with the images.
std::optional<ImuFeed> FeedOf(const LiveArguments& arguments, const SensorCalibration& sensors) {
  if (!WantsImu(arguments.slam)) return std::nullopt;
  if (sensors.imu) return ImuFeed{*sensors.imu, {}};
  if (arguments.slam.imu.empty()) return std::nullopt;
  throw InvalidArgument("--imu asks for an IMU, which this camera does not have");
}

LiveCameraOptions QueueOptions(const SlamRunOptions& options, TumRecorder* recorder) {
  LiveCameraOptions queue;
  if (options.imu) {
    queue.imu_lead = kImuLead;
    queue.imu_time_offset = options.imu->calibration.time_offset;
  }
  if (recorder != nullptr) {
    queue.on_image = [recorder](const RgbdImage& image, std::span<const ImuSample> readings) {
      recorder->Add(image, readings);
    };
  }
  return queue;
}

SlamRun TrackCamera(const LiveArguments& arguments, ImageSource& device, const RgbdSensor& sensor,
                    const SlamRunOptions& options, TumRecorder* recorder, SlamSession& session) {
  LiveCamera camera(device, QueueOptions(options, recorder));
  const Stopwatch stopwatch;
  const Watch watch(
      [&] {
        return session.IsStopRequested() ||
               (arguments.seconds > 0.0 && stopwatch.Seconds() > arguments.seconds);
      },
      [&] { camera.Stop(); });
  return session.Track(
      [&](const RunCallbacks& callbacks) { return RunSlam(camera, sensor, options, callbacks); });
}

// What run.json holds of a recording.
struct RecordingJson {
  nlohmann::json counts;
  std::optional<nlohmann::json> identity;  // empty if the recording cannot be read
};

// Ends the recording; failures go to those of the run, whose results do not depend on it.
RecordingJson EndRecording(TumRecorder& recorder, const RgbdSensor& sensor, SlamRun* run) {
  const RecordingCounts counts = recorder.Finish();
  const std::string folder = recorder.folder().string();
  if (!counts.failure.empty()) run->failures.push_back("recording: " + counts.failure);
  if (counts.missed > 0) {
    fmt::print(stderr, "highwall live: warning: {} images were not recorded\n", counts.missed);
  }
  fmt::print(stderr, "highwall live: recorded {} images{} in {}\n", counts.images,
             counts.readings > 0 ? fmt::format(" and {} readings", counts.readings) : "", folder);
  RecordingJson json{.counts = {{"folder", AbsoluteName(folder)},
                                {"images", counts.images},
                                {"readings", counts.readings},
                                {"missed", counts.missed}},
                     .identity = {}};
  if (counts.images == 0) return json;
  try {
    json.identity = ToJson(IdentityOf(*OpenDataset(recorder.folder(), sensor)));
  } catch (const IoError& error) {
    run->failures.push_back(std::string("recording: ") + error.what());
  }
  return json;
}

int RunCamera(const LiveArguments& arguments) {
  SlamSession session("live", arguments.slam);
  const OpenedCamera opened = OpenCamera(arguments);
  const SensorCalibration& sensors = *opened.images->calibration();
  const RgbdSensor& sensor = sensors.sensor;
  SlamRunOptions options = MakeOptions(arguments.slam);
  options.imu = FeedOf(arguments, sensors);
  std::optional<TumRecorder> recorder;
  if (!arguments.record.empty()) recorder.emplace(arguments.record, sensors);
  session.Begin(sensor, &options);
  SlamRun run = TrackCamera(arguments, *opened.images, sensor, options,
                            recorder ? &*recorder : nullptr, session);
  std::optional<RecordingJson> recorded;
  if (recorder) recorded = EndRecording(*recorder, sensor, &run);
  WarnOfSensors("live", run, sensor.depth_factor);
  if (const auto exit_code = session.EndWithoutPose(run, arguments.camera)) return *exit_code;
  // The recording has a calibration of its own, with the unit of its depth.
  const std::string calibration =
      recorder ? CalibrationFile(arguments.record).string() : opened.origin;
  nlohmann::json report = RunJson(run, options, arguments.record, calibration);
  report["camera"] = arguments.camera;
  report["depth_noise"] = ToJson(sensor.depth_noise);
  report["settings"] = ChangedSettings(options.slam);
  if (recorded) report["recorded"] = recorded->counts;
  if (recorded && recorded->identity) report["recording"] = *recorded->identity;
  return session.Write(run, std::move(report), false);
}

int RunLiveCommand(const LiveArguments& arguments) {
  if (arguments.slam.print_settings) {
    fmt::print("{}", SettingsFile(MakeOptions(arguments.slam).slam));
    return kExitOk;
  }
  try {
    return arguments.list ? ListCameras() : RunCamera(arguments);
  } catch (const NoCamera& error) {
    fmt::print(stderr, "highwall live: {}\n", OneLine(error.what()));
    return kExitUsage;
  }
}

}  // namespace

void AddLiveCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<LiveArguments>();
  CLI::App* command =
      app.add_subcommand("live", "Estimate the trajectory and the map while a camera runs");
  AddLiveOptions(command, arguments.get());
  command->footer("Example:\n  highwall live --camera openni2 --out run --view --record recording");
  command->callback([arguments, &action] {
    CheckArguments(arguments->slam);
    action = [arguments] { return RunLiveCommand(*arguments); };
  });
}

}  // namespace highwall::apps
