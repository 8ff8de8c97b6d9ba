// highwall calibrate: where the camera sits on the IMU, from a recording.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/inertial/camera_imu_calibration.h>
#include <highwall/frontend/local/intrinsics.h>

#include "calibration_file.h"
#include "commands.h"
#include "imu_input.h"
#include "opened_dataset.h"
#include "output_checks.h"
#include "progress.h"
#include "slam_run.h"

namespace highwall::apps {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

struct CalibrateArguments {
  std::filesystem::path input;
  std::string config, trajectory, out;
  bool keep_depth = false;
  bool intrinsics = false;
  bool json = false;
};

void Warn(const std::string& text) {
  fmt::print(stderr, "highwall calibrate: warning: {}\n", OneLine(text));
}

// What the images tell alone.
struct TrackedImages {
  Trajectory trajectory;                            // all frames, adjusted together
  std::optional<IntrinsicsCalibration> intrinsics;  // where asked for
  std::optional<FrameTimingEstimate> timing;        // where they were tracked
};

// A time of the rows, as it was stated and as the images have it.
struct RowTime {
  const char *key, *name;
  double FrameTiming::*member;
};
constexpr RowTime kRowTimes[] = {{"colour_readout", "colour rows", &FrameTiming::colour_readout},
                                 {"depth_readout", "depth rows", &FrameTiming::depth_readout},
                                 {"depth_delay", "depth delay", &FrameTiming::depth_delay}};

// [s] A fifth of what is taken for its deviation before anything is known.
bool IsSeen(const RowTime& time, const FrameTimingEstimate& found) {
  return found.sigma.*time.member < 0.003;
}

// What is stated stands until it is two standard deviations off, as in tracking.
bool IsOff(const RowTime& time, const FrameTimingEstimate& found, const FrameTiming& stated) {
  const double off = std::abs(found.value.*time.member - stated.*time.member);
  return IsSeen(time, found) && off > 2.0 * (found.sigma.*time.member);
}

TrackedImages TrackImages(const Dataset& dataset, const RgbdSensor& sensor, bool intrinsics) {
  SlamRunOptions options;
  options.slam = Deterministic(options.slam);  // one recording, one calibration
  options.dense = false;
  options.adjust_all = true;
  options.intrinsics = intrinsics;
  Progress progress("tracking");
  const SlamRun run = RunSlam(dataset, sensor, options,
                              [&progress](const FrameResult&, const RgbdImage&, std::size_t done,
                                          std::size_t total) { progress.Update(done, total); });
  RequireWhole(run);
  return {run.largest.adjusted.empty() ? run.largest.trajectory : run.largest.adjusted,
          run.intrinsics, run.timing};
}

// Twice: what is tracked with a wrong camera is tracked worse. The sensor gets what the last round
// finds and sees; the rest stays as it was known before both.
TrackedImages TrackWithIntrinsics(const Dataset& dataset, RgbdSensor* sensor) {
  const PinholeCamera& stated = sensor->camera;
  const std::array before{stated.fx, stated.fy, stated.cx, stated.cy};
  TrackedImages tracked;
  for (int round = 0; round < 2; ++round) {
    tracked = TrackImages(dataset, *sensor, true);
    if (!tracked.intrinsics) throw std::runtime_error("no frame could be tracked");
    const Eigen::Vector4d& k = tracked.intrinsics->intrinsics;
    PinholeCamera& camera = sensor->camera;
    const std::array known{&camera.fx, &camera.fy, &camera.cx, &camera.cy};
    for (std::size_t i = 0; i < known.size(); ++i) {
      *known[i] = tracked.intrinsics->seen[i] ? k[static_cast<Eigen::Index>(i)] : before[i];
    }
  }
  return tracked;
}

struct Recording {
  std::filesystem::path dataset;
  std::string config;      // as --config
  std::string trajectory;  // empty: to be tracked
};

// A run, which names its dataset and its configuration, or a dataset.
Recording Find(const CalibrateArguments& arguments) {
  const std::filesystem::path file = arguments.input / "run.json";
  if (!std::filesystem::exists(file)) {
    return {arguments.input, arguments.config, arguments.trajectory};
  }
  std::ifstream stream(file);
  const nlohmann::json report = nlohmann::json::parse(stream, nullptr, false);
  const auto text = [&](const char* key) {
    const nlohmann::json::json_pointer pointer(key);
    const bool is_there =
        report.is_object() && report.contains(pointer) && report.at(pointer).is_string();
    return is_there ? report.at(pointer).get<std::string>() : std::string();
  };
  if (text("/options/imu") != "off" && arguments.trajectory.empty()) {
    throw IoError(file, "its poses lean on the IMU: take a run of highwall slam --imu off");
  }
  if (!std::filesystem::is_directory(text("/dataset"))) {
    throw IoError(file, "names the dataset " + text("/dataset") + ", which is not there");
  }
  Recording recording{text("/dataset"), arguments.config, arguments.trajectory};
  const std::string used = text("/calibration");
  if (recording.config.empty() && std::filesystem::is_regular_file(used)) recording.config = used;
  if (recording.trajectory.empty()) {
    recording.trajectory = (arguments.input / "trajectory.txt").string();
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
  for (const std::string& advice : found.advice) fmt::print("not seen     {}\n", advice);
}

void PrintText(const IntrinsicsCalibration& found) {
  const Eigen::Vector4d &k = found.intrinsics, &s = found.sigma;
  fmt::print("focal        {:.2f} {:.2f} +- {:.2f} {:.2f} px ({} points from {} keyframes)\n", k[0],
             k[1], s[0], s[1], found.points, found.keyframes);
  fmt::print("centre       {:.2f} {:.2f} +- {:.2f} {:.2f} px\n", k[2], k[3], s[2], s[3]);
  for (const std::string& advice : found.advice) fmt::print("not seen     {}\n", advice);
}

void PrintText(const FrameTimingEstimate& found) {
  for (const RowTime& time : kRowTimes) {
    fmt::print("{:12} {:.1f} +- {:.1f} ms{}\n", time.name, 1e3 * (found.value.*time.member),
               1e3 * (found.sigma.*time.member), IsSeen(time, found) ? "" : ": hardly seen");
  }
}

nlohmann::ordered_json ToJson(const FrameTimingEstimate& found) {
  nlohmann::ordered_json json;
  for (const RowTime& time : kRowTimes) {
    json[time.key] = {{"value_s", found.value.*time.member},
                      {"sigma_s", found.sigma.*time.member},
                      {"seen", IsSeen(time, found)}};
  }
  return json;
}

nlohmann::ordered_json ToJson(const IntrinsicsCalibration& found) {
  const auto list = [](const Eigen::Vector4d& v) {
    return std::vector<double>(v.data(), v.data() + v.size());
  };
  return {{"fx_fy_cx_cy", list(found.intrinsics)},
          {"sigma_px", list(found.sigma)},
          {"seen", found.seen},
          {"error", found.error},
          {"keyframes", found.keyframes},
          {"points", found.points},
          {"observations", found.observations},
          {"advice", found.advice}};
}

nlohmann::ordered_json ToJson(const CameraImuCalibration& found) {
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

// [Hz] to a tenth.
double RateOf(const std::vector<ImuSample>& samples) {
  const double duration = ToSeconds(samples.back().stamp - samples.front().stamp);
  return 0.1 * std::round(10.0 * static_cast<double>(samples.size() - 1) / duration);
}

// Beyond doubt, and more than half a percent.
bool IsWrong(const CameraImuCalibration& found) {
  const double off = std::abs(found.depth_scale - 1.0);
  return off > 0.005 && off > 3.0 * found.depth_scale_sigma;
}

// The calibration's times become those that were found to be off; returns their deviations, 0 of
// what stays as it was stated.
FrameTiming TakeTiming(const std::optional<FrameTimingEstimate>& found, FrameTiming* stated) {
  FrameTiming sigma;
  if (!found) return sigma;
  for (const RowTime& time : kRowTimes) {
    if (!IsOff(time, *found, *stated)) continue;
    stated->*time.member = found->value.*time.member;
    sigma.*time.member = found->sigma.*time.member;
  }
  // A read-out below 0 is one of 0.
  stated->colour_readout = std::max(stated->colour_readout, 0.0);
  stated->depth_readout = std::max(stated->depth_readout, 0.0);
  return sigma;
}

int RunCalibrate(const CalibrateArguments& arguments) {
  if (!arguments.out.empty()) RequireFile(arguments.out);
  const Recording recording = Find(arguments);
  const OpenedDataset opened = OpenDataset(recording.config, recording.dataset);
  const Dataset& dataset = *opened.images;
  RunConfig config = opened.config;
  const ImuCalibration guess = config.imu.value_or(ImuCalibration{});
  const std::optional<ImuInput> imu = LoadImu(dataset, guess);
  if (!imu) throw IoError(recording.dataset, "has no IMU (imu.csv)");
  if (!config.imu) {
    Warn(recording.dataset.string() +
         ": no calibration names the noise of the IMU: that of EuRoC's is taken (find it with "
         "highwall imu-noise)");
  }
  for (const std::string& warning : imu->warnings) Warn(warning);
  if (!imu->IsUsable()) throw IoError(imu->file, "cannot be used");
  TrackedImages images;
  if (arguments.intrinsics) {
    images = TrackWithIntrinsics(dataset, &config.sensor);
  } else if (recording.trajectory.empty()) {
    images = TrackImages(dataset, config.sensor, false);
  } else {
    images.trajectory = ReadTumTrajectory(recording.trajectory);
  }
  CameraImuCalibration found;
  try {
    const Progress progress("fitting");
    found =
        CalibrateCameraImu(images.trajectory, imu->samples,
                           {.noise = guess.noise, .estimate_depth_scale = !arguments.keep_depth});
  } catch (const InvalidArgument& error) {
    throw IoError(recording.trajectory.empty() ? recording.dataset.string() : recording.trajectory,
                  error.what());
  }
  if (arguments.json) {
    nlohmann::ordered_json json = ToJson(found);
    if (images.intrinsics) json["intrinsics"] = ToJson(*images.intrinsics);
    if (images.timing) json["row_times"] = ToJson(*images.timing);
    fmt::print("{}\n", json.dump());
  } else {
    PrintText(found, !arguments.keep_depth);
    if (images.intrinsics) PrintText(*images.intrinsics);
    if (images.timing) PrintText(*images.timing);
  }
  if (arguments.out.empty()) return kExitOk;
  config.imu = guess;
  config.imu->T_BC = found.T_BC;
  config.imu->time_offset = found.time_offset;
  config.imu->rate = RateOf(imu->samples);
  if (IsWrong(found)) config.sensor.depth_factor /= found.depth_scale;
  const FrameTiming timing_sigma = TakeTiming(images.timing, &config.sensor.timing);
  WriteConfig(arguments.out, config, timing_sigma);
  if (!arguments.json) {
    fmt::print("written      {}{}\n", arguments.out,
               IsWrong(found)
                   ? fmt::format(", with depth_factor {:.6g}", config.sensor.depth_factor)
                   : "");
  }
  return kExitOk;
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, CommandAction& action) {
  CLI::App* command = app.add_subcommand(
      "calibrate", "Find where the camera sits on the IMU, and how their clocks and metres differ");
  const auto arguments = std::make_shared<CalibrateArguments>();
  command
      ->add_option("input", arguments->input,
                   "Dataset with an IMU, or the folder of a run of `highwall slam --imu off`")
      ->required();
  command->add_option("--config", arguments->config,
                      "tum1, tum2, tum3 or a YAML file; of an IMU only its noise is taken from it "
                      "[default: calibration.yaml of the dataset]");
  CLI::Option* trajectory = command->add_option(
      "--trajectory", arguments->trajectory, "T_WC by the images alone, instead of tracking them");
  command
      ->add_flag("--intrinsics", arguments->intrinsics,
                 "Find the focal lengths and the principal point as well: tracks the images twice")
      ->excludes(trajectory);
  command->add_option("--out", arguments->out, "calibration.yaml to write");
  command->add_flag("--keep-depth", arguments->keep_depth, "The scale of the depth is right");
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->footer(
      "Example: move the camera for a minute through one place, turning it about all of its axes, "
      "then\n  highwall calibrate recording --out calibration.yaml");
  command->callback(
      [arguments, &action] { action = [arguments] { return RunCalibrate(*arguments); }; });
}

}  // namespace highwall::apps
