#include "calibrated_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "progress.h"
#include "slam_run.h"

namespace highwall::apps {
namespace {

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

CalibratedImages Track(const Dataset& dataset, const RgbdSensor& sensor, bool intrinsics) {
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

void PrintText(const CameraCalibration& found) {
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

CalibratedImages CalibrateImages(const Dataset& dataset, const RgbdSensor& sensor) {
  return Track(dataset, sensor, false);
}

CalibratedImages CalibrateImagesAndIntrinsics(const Dataset& dataset, RgbdSensor* sensor) {
  const PinholeCamera& stated = sensor->camera;
  const std::array before{stated.fx, stated.fy, stated.cx, stated.cy};
  CalibratedImages tracked;
  for (int round = 0; round < 2; ++round) {
    tracked = Track(dataset, *sensor, true);
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

void Print(const CalibratedImages& found) {
  if (found.intrinsics) PrintText(*found.intrinsics);
  if (found.timing) PrintText(*found.timing);
}

void AddTo(nlohmann::ordered_json* report, const CalibratedImages& found) {
  if (found.intrinsics) (*report)["intrinsics"] = ToJson(*found.intrinsics);
  if (found.timing) (*report)["row_times"] = ToJson(*found.timing);
}

}  // namespace highwall::apps
