// highwall calibrate: calibrates the sensors of a recording: depth and rolling-shutter times of the
// camera, and the extrinsics between camera and IMU.
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/calibration/camera_imu_calibration.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "files/trajectory_input.h"
#include "run/calibrated_images.h"
#include "run/calibration_file.h"
#include "run/imu_input.h"
#include "run/opened_dataset.h"
#include "run/output_checks.h"
#include "run/recording_identity.h"
#include "run/run_dataset.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

struct CalibrateArguments {
  std::filesystem::path input;
  std::string config, trajectory, out;
  double max_pair_difference = kMaxPairDifference;  // [s]
  BagTopics topics;
  bool keep_depth = false;
  bool intrinsics = false;
  bool json = false;
};

struct Recording {
  std::filesystem::path dataset;
  std::string config;           // as given to --config
  std::string trajectory;       // empty: to be estimated
  std::filesystem::path run{};  // that named it; empty: none
  BagTopics topics{};           // of that run
};

// Resolves the input: a run, which names its dataset and configuration, or a dataset.
Recording Find(const CalibrateArguments& arguments) {
  const std::filesystem::path file = arguments.input / "run.json";
  if (!std::filesystem::exists(file)) {
    return {arguments.input, arguments.config, arguments.trajectory};
  }
  const nlohmann::json report = ReadJson(file);
  const auto text = [&](const char* key) {
    const nlohmann::json::json_pointer pointer(key);
    const bool is_there =
        report.is_object() && report.contains(pointer) && report.at(pointer).is_string();
    return is_there ? StringIn(report.at(pointer)) : std::string();
  };
  if (text("/options/imu") != "off" && arguments.trajectory.empty()) {
    throw IoError(file, "its poses depend on the IMU: give a run of highwall slam --imu off");
  }
  const std::vector<std::filesystem::path> datasets = DatasetsOfRun(arguments.input, report);
  if (datasets.empty()) {
    throw IoError(file, "names the dataset " + text("/dataset") + ", which is not there");
  }
  if (datasets.size() > 1) {
    throw IoError(file, "names the dataset " + text("/dataset") +
                            " without its folder, which may be " + datasets[0].string() + " or " +
                            datasets[1].string() + ": give the dataset and --trajectory");
  }
  Recording recording{datasets.front(), arguments.config, arguments.trajectory, arguments.input};
  recording.topics = InputOptionsOfRun(report).topics;
  if (recording.config.empty()) recording.config = CalibrationOfRun(arguments.input, report);
  if (recording.trajectory.empty()) {
    recording.trajectory =
        (arguments.input / NameOfSubmap(kTrajectoryFile, FirstPlace(report))).string();
  }
  return recording;
}

std::string Triple(const Eigen::Vector3d& v, double unit, int decimals) {
  return fmt::format("{:.{}f} {:.{}f} {:.{}f}", unit * v.x(), decimals, unit * v.y(), decimals,
                     unit * v.z(), decimals);
}

void PrintText(const CameraImuCalibration& found, bool with_scale) {
  const Eigen::Matrix3d R = found.T_BC.R();
  fmt::print("poses        {} of the camera, {:.1f} mm and {:.2f} deg off (RMS)\n", found.poses,
             1e3 * found.position_error, kDegrees * found.rotation_error);
  fmt::print("camera at    {} mm in the IMU's frame, +- {} mm\n", Triple(found.T_BC.p(), 1e3, 1),
             Triple(found.lever_arm_sigma, 1e3, 1));
  for (int i = 0; i < 3; ++i) {
    fmt::print("{:12} {} is the camera's {} in it\n", i == 0 ? "axes" : "",
               Triple(R.col(i), 1.0, 4), "xyz"[i]);
  }
  fmt::print("             +- {} deg about them\n", Triple(found.rotation_sigma, kDegrees, 3));
  fmt::print("time offset  {:.2f} +- {:.2f} ms (t_imu = t_cam + t_d)\n", 1e3 * found.time_offset,
             1e3 * found.time_offset_sigma);
  if (with_scale) {
    fmt::print("depth scale  {:.4f} +- {:.4f} (true depth = scale x measured)\n", found.depth_scale,
               found.depth_scale_sigma);
  }
  fmt::print("biases       {} rad/s, {} m/s^2\n", Triple(found.bias.head<3>(), 1.0, 4),
             Triple(found.bias.tail<3>(), 1.0, 3));
  for (const std::string& advice : found.advice) fmt::print("unobserved   {}\n", advice);
}

nlohmann::ordered_json CalibrationJson(const CameraImuCalibration& found) {
  const auto list = [](const auto& v) {
    return std::vector<double>(v.data(), v.data() + v.size());
  };
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T_BC = found.T_BC.Matrix();
  return {{"poses", found.poses},
          {"T_BC", std::vector<double>(T_BC.data(), T_BC.data() + 16)},
          {"lever_arm_sigma_m", list(found.lever_arm_sigma)},
          {"rotation_sigma_rad", list(found.rotation_sigma)},
          {"time_offset_s", found.time_offset},
          {"time_offset_sigma_s", found.time_offset_sigma},
          {"depth_scale", found.depth_scale},
          {"depth_scale_sigma", found.depth_scale_sigma},
          {"bias", list(found.bias)},
          {"bias_sigma", list(found.bias_sigma)},
          {"position_error_m", found.position_error},
          {"rotation_error_rad", found.rotation_error},
          {"advice", found.advice}};
}

// [Hz] rounded to a tenth.
double RateOf(const std::vector<ImuSample>& samples) {
  const double duration = ToSeconds(samples.back().stamp - samples.front().stamp);
  return 0.1 * std::round(10.0 * static_cast<double>(samples.size() - 1) / duration);
}

// Significant, and more than half a percent.
bool IsWrong(const CameraImuCalibration& found) {
  const double off = std::abs(found.depth_scale - 1.0);
  return off > 0.005 && off > 3.0 * found.depth_scale_sigma;
}

// Opens the IMU data; empty if there is none. Prints warnings.
std::optional<ImuInput> OpenImu(const Recording& recording, const OpenedDataset& opened) {
  const std::optional<ImuInput> imu =
      LoadImu(*opened.images, opened.config.imu.value_or(ImuCalibration{}));
  if (!imu) {
    if (!recording.trajectory.empty()) throw IoError(recording.dataset, "has no IMU (imu.csv)");
    return imu;
  }
  if (!opened.config.imu) {
    PrintWarning(
        "calibrate",
        recording.dataset.string() +
            ": no calibration states the noise of the IMU; that of EuRoC's is assumed (highwall "
            "imu-noise measures it)");
  }
  for (const std::string& warning : imu->warnings) PrintWarning("calibrate", warning);
  if (!imu->IsUsable()) throw IoError(imu->file, "cannot be used");
  return imu;
}

CameraImuCalibration FitImu(const Recording& recording, const Trajectory& trajectory,
                            const ImuInput& imu, bool keep_depth) {
  const Progress progress("fitting");
  std::string reason;
  const std::optional<CameraImuCalibration> found =
      CalibrateCameraImu(trajectory, imu.samples,
                         {.noise = imu.calibration.noise,
                          .gyroscope_range = imu.calibration.gyroscope_range,
                          .accelerometer_range = imu.calibration.accelerometer_range,
                          .estimate_depth_scale = !keep_depth},
                         &reason);
  if (!found) {
    throw IoError(recording.trajectory.empty() ? recording.dataset.string() : recording.trajectory,
                  reason);
  }
  return *found;
}

// Copies the IMU calibration to the configuration.
void Take(const CameraImuCalibration& found, const ImuInput& imu, RunConfig* config) {
  config->imu = imu.calibration;  // without a range that the readings exceed
  config->imu->T_BC = found.T_BC;
  config->imu->time_offset = found.time_offset;
  config->imu->rate = RateOf(imu.samples);
  if (!IsWrong(found)) return;
  config->sensor.depth_factor /= found.depth_scale;
  config->sensor.inverse_depth_offset /= found.depth_scale;  // 1/m: the metric scale has changed
  config->sensor.depth_pattern.nodes /= found.depth_scale;
}

int RunCalibrate(const CalibrateArguments& arguments) {
  if (!arguments.out.empty()) RequireFile(arguments.out);
  const Recording recording = Find(arguments);
  const bool has_topics = arguments.topics != BagTopics();
  const DatasetOptions input{.max_stamp_difference = arguments.max_pair_difference,
                             .topics = has_topics ? arguments.topics : recording.topics};
  const OpenedDataset opened = OpenWithConfig(recording.config, recording.dataset, input);
  PrintSources("calibrate", opened);
  if (!recording.run.empty()) {
    RequireRecordingOfRun(recording.dataset, *opened.images, recording.run);
  }
  const std::optional<ImuInput> imu = OpenImu(recording, opened);
  RunConfig config = opened.config;
  const ImageCalibrationOptions wanted{
      .intrinsics = arguments.intrinsics, .keep_depth = arguments.keep_depth, .images = input};
  std::optional<CalibratedImages> images;
  if (recording.trajectory.empty() || arguments.intrinsics) {
    images = CalibrateImages(recording.dataset, wanted, &config.sensor);
  }
  std::optional<CameraImuCalibration> found;
  if (imu) {
    const Trajectory& poses =
        images ? images->trajectory : ReadStampedPoses("calibrate", recording.trajectory);
    found = FitImu(recording, poses, *imu, arguments.keep_depth);
  }
  if (arguments.json) {
    nlohmann::ordered_json json =
        found ? CalibrationJson(*found) : nlohmann::ordered_json::object();
    if (images) AddTo(&json, *images, wanted);
    fmt::print("{}\n", JsonText(json));
  } else {
    if (found) {
      PrintText(*found, !arguments.keep_depth);
    } else {
      fmt::print("imu          none (imu.csv): the camera is calibrated alone\n");
    }
    if (images) Print(*images, wanted);
  }
  if (arguments.out.empty()) return kExitOk;
  CalibrationSigma sigma;
  if (images) sigma = TakeFound(*images, &config.sensor);
  if (found) Take(*found, *imu, &config);
  WriteConfig(arguments.out, config, sigma);
  if (!arguments.json) {
    fmt::print("written      {}{}\n", arguments.out,
               found && IsWrong(*found)
                   ? fmt::format(", with depth_factor {:.6g}", config.sensor.depth_factor)
                   : "");
  }
  return kExitOk;
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, CommandAction& action) {
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Estimate the row times of a camera, the errors of its depth, and its pose on the IMU");
  const auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("input", arguments->input,
                   "Dataset, or the folder of a run of `highwall slam --imu off` with an IMU")
      ->required();
  command->add_option("--config", arguments->config,
                      "tum1, tum2, tum3 or a calibration file; of an IMU only its noise and ranges "
                      "are taken from it [default: calibration.yaml of the dataset]");
  CLI::Option* trajectory = command->add_option(
      "--trajectory", arguments->trajectory, "T_WC by the images alone, instead of tracking them");
  command
      ->add_flag("--intrinsics", arguments->intrinsics,
                 "Estimate the focal lengths and the principal point as well, and track again")
      ->excludes(trajectory);
  command->add_option("--out", arguments->out, "calibration.yaml to write");
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddTopics(command, &arguments->topics);
  command->add_flag("--keep-depth", arguments->keep_depth,
                    "Keep the depth as it is: no scale, no offset, no pattern");
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->footer(
      "Example: move the camera for a minute through one place, turning it about all of its axes, "
      "then\n  highwall calibrate recording --out calibration.yaml");
  command->callback(
      [arguments, &action] { action = [arguments] { return RunCalibrate(*arguments); }; });
}

}  // namespace highwall::apps
