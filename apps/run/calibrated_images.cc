#include "run/calibrated_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "cli/progress.h"
#include "run/opened_dataset.h"
#include "run/slam_run.h"

namespace highwall::apps {
namespace {

// Each round leaves about two thirds of the error of the rolling-shutter times.
constexpr int kRounds = 6;

// A rolling-shutter parameter with its names.
struct RowTime {
  const char *key, *name;
  double FrameTiming::*member;
};
constexpr RowTime kRowTimes[] = {{"colour_readout", "colour rows", &FrameTiming::colour_readout},
                                 {"depth_readout", "depth rows", &FrameTiming::depth_readout},
                                 {"depth_delay", "depth delay", &FrameTiming::depth_delay}};

// [s] The threshold is a fifth of the prior standard deviation.
bool IsSeen(const RowTime& time, const FrameTimingEstimate& found) {
  return found.sigma.*time.member < 0.003;
}

// A stated value is kept until it is two standard deviations off, as in tracking.
bool IsOff(const RowTime& time, const FrameTimingEstimate& found, const FrameTiming& stated) {
  const double off = std::abs(found.value.*time.member - stated.*time.member);
  return IsSeen(time, found) && off > 2.0 * (found.sigma.*time.member);
}

// A stated value is kept until it is significantly off. The images constrain the offset, but not
// the scale.
bool IsOff(const CameraCalibration& found, double stated) {
  return found.inverse_depth_seen &&
         std::abs(found.inverse_depth_offset - stated) > 3.0 * found.inverse_depth_sigma;
}

// Does the same for the residual distortion.
bool IsPatternOff(const CameraCalibration& found, const DepthPattern& stated) {
  const DepthPattern off{found.depth_pattern.nodes - stated.nodes};
  return found.depth_pattern_seen && off.Rms() > 3.0 * found.depth_pattern_sigma.Rms();
}

// The returned inverse_depth_offset and depth_pattern are residuals.
CalibratedImages Track(const std::filesystem::path& directory, const RgbdSensor& sensor,
                       const ImageCalibrationOptions& wanted, int round) {
  const std::unique_ptr<const Dataset> images = OpenDataset(directory, sensor, wanted.images);
  SlamRunOptions options;
  options.slam = Deterministic(options.slam);  // one recording, one calibration: reproducible
  options.slam.depth_pattern.enabled = false;  // estimated from the whole recording, at the end
  options.dense = false;
  options.adjust_all = true;
  options.calibrate =
      CameraCalibrationOptions{.intrinsics = wanted.intrinsics, .pattern_of = sensor.camera};
  Progress progress(round == 1
                        ? "tracking"
                        : fmt::format("tracking with the calibration found, round {}", round));
  const SlamRun run =
      RunSlam(*images, sensor, options,
              {.on_frame = [&progress](const FrameResult&, const RgbdImage&, std::size_t done,
                                       std::size_t total) { progress.Update(done, total); }});
  if (!run.failures.empty()) throw IoError(directory, run.failures.front() + ": record for longer");
  if (!run.camera) throw IoError(directory, "no frame could be tracked");
  CalibratedImages found;
  found.trajectory = run.largest.adjusted.empty() ? run.largest.trajectory : run.largest.adjusted;
  found.camera = *run.camera;
  found.timing = run.sensor.timing;
  return found;
}

void TakeIntrinsics(const CameraCalibration& found, PinholeCamera* camera) {
  const std::array known{&camera->fx, &camera->fy, &camera->cx, &camera->cy};
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (found.seen[i]) *known[i] = found.intrinsics[static_cast<Eigen::Index>(i)];
  }
}

// Replaces the times that are off by the estimates; returns their standard deviations, 0 for times
// that are kept.
FrameTiming TakeTiming(const FrameTimingEstimate& found, FrameTiming* timing) {
  FrameTiming sigma;
  for (const RowTime& time : kRowTimes) {
    if (!IsOff(time, found, *timing)) continue;
    timing->*time.member = found.value.*time.member;
    sigma.*time.member = found.sigma.*time.member;
  }
  // A read-out time cannot be negative.
  timing->colour_readout = std::max(timing->colour_readout, 0.0);
  timing->depth_readout = std::max(timing->depth_readout, 0.0);
  return sigma;
}

// Whether the times before and after the round differ by at most their standard deviations.
bool IsSettled(const FrameTimingEstimate& found, const FrameTiming& before,
               const FrameTiming& after) {
  return std::ranges::all_of(kRowTimes, [&](const RowTime& time) {
    return std::abs(after.*time.member - before.*time.member) <= found.sigma.*time.member;
  });
}

void PrintIntrinsics(const CameraCalibration& found) {
  const Eigen::Vector4d &k = found.intrinsics, &s = found.sigma;
  fmt::print("focal        {:.2f} {:.2f} +- {:.2f} {:.2f} px ({} points from {} keyframes)\n", k[0],
             k[1], s[0], s[1], found.points, found.keyframes);
  fmt::print("centre       {:.2f} {:.2f} +- {:.2f} {:.2f} px\n", k[2], k[3], s[2], s[3]);
}

void PrintOffset(const CameraCalibration& found) {
  constexpr double kFar = 3.0;  // [m]
  const double share = -kFar * found.inverse_depth_offset;
  fmt::print("depth        reads {:.2f} +- {:.2f} % too {} at {:.0f} m ({:.4f} +- {:.4f} / m)\n",
             100.0 * std::abs(share), 100.0 * kFar * found.inverse_depth_sigma,
             share < 0.0 ? "short" : "long", kFar, found.inverse_depth_offset,
             found.inverse_depth_sigma);
  fmt::print("pattern      depth is off by {:.2f} +- {:.2f} % over the image at {:.0f} m (RMS)\n",
             100.0 * kFar * found.depth_pattern.Rms(),
             100.0 * kFar * found.depth_pattern_sigma.Rms(), kFar);
}

void PrintText(const FrameTimingEstimate& found) {
  for (const RowTime& time : kRowTimes) {
    fmt::print("{:12} {:.1f} +- {:.1f} ms{}\n", time.name, 1e3 * (found.value.*time.member),
               1e3 * (found.sigma.*time.member), IsSeen(time, found) ? "" : ": hardly observed");
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

nlohmann::ordered_json ToJson(const CameraCalibration& found) {
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

}  // namespace

CalibratedImages CalibrateImages(const std::filesystem::path& dataset,
                                 const ImageCalibrationOptions& options, RgbdSensor* sensor) {
  const RgbdSensor stated = *sensor;
  // The depth of such a recording is computed with its camera.
  const DatasetReader* const reader = FindDatasetReader(dataset);
  const bool keep_depth = options.keep_depth || (reader != nullptr && reader->fixed_camera);
  CalibratedImages found;
  for (int round = 1; round <= kRounds; ++round) {
    const RgbdSensor tracked = *sensor;
    found = Track(dataset, tracked, options, round);
    found.rounds = round;
    found.camera.inverse_depth_offset += tracked.inverse_depth_offset;
    found.camera.depth_pattern.nodes += tracked.depth_pattern.nodes;
    *sensor = stated;
    TakeIntrinsics(found.camera, &sensor->camera);
    if (!keep_depth && IsOff(found.camera, stated.inverse_depth_offset)) {
      sensor->inverse_depth_offset = found.camera.inverse_depth_offset;
    }
    if (!keep_depth && IsPatternOff(found.camera, stated.depth_pattern)) {
      sensor->depth_pattern = found.camera.depth_pattern;
    }
    TakeTiming(found.timing, &sensor->timing);
    const bool once_more =
        round == 1 &&
        (options.intrinsics || sensor->inverse_depth_offset != tracked.inverse_depth_offset ||
         sensor->depth_pattern.nodes != tracked.depth_pattern.nodes);
    if (!once_more && IsSettled(found.timing, tracked.timing, sensor->timing)) break;
  }
  sensor->timing = stated.timing;
  return found;
}

CalibrationSigma TakeFound(const CalibratedImages& found, RgbdSensor* sensor) {
  CalibrationSigma sigma;
  sigma.timing = TakeTiming(found.timing, &sensor->timing);
  if (sensor->inverse_depth_offset == found.camera.inverse_depth_offset) {
    sigma.inverse_depth_offset = found.camera.inverse_depth_sigma;
  }
  if (sensor->depth_pattern.nodes == found.camera.depth_pattern.nodes) {
    sigma.depth_pattern = found.camera.depth_pattern_sigma.Rms();
  }
  return sigma;
}

void Print(const CalibratedImages& found, const ImageCalibrationOptions& options) {
  if (options.intrinsics) PrintIntrinsics(found.camera);
  PrintOffset(found.camera);
  for (const std::string& advice : found.camera.advice) fmt::print("unobserved   {}\n", advice);
  PrintText(found.timing);
}

void AddTo(nlohmann::ordered_json* report, const CalibratedImages& found,
           const ImageCalibrationOptions& options) {
  if (options.intrinsics) (*report)["intrinsics"] = ToJson(found.camera);
  (*report)["inverse_depth_offset"] = {{"value_per_m", found.camera.inverse_depth_offset},
                                       {"sigma_per_m", found.camera.inverse_depth_sigma},
                                       {"seen", found.camera.inverse_depth_seen}};
  const auto list = [](const DepthPattern& pattern) {
    return std::vector<double>(pattern.nodes.data(), pattern.nodes.data() + pattern.nodes.size());
  };
  (*report)["depth_pattern"] = {{"columns", DepthPattern::kColumns},
                                {"rows", DepthPattern::kRows},
                                {"values_per_m", list(found.camera.depth_pattern)},
                                {"sigma_per_m", list(found.camera.depth_pattern_sigma)},
                                {"seen", found.camera.depth_pattern_seen}};
  (*report)["row_times"] = ToJson(found.timing);
  (*report)["rounds"] = found.rounds;
}

}  // namespace highwall::apps
