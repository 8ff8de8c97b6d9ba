#include <algorithm>

#include <nlohmann/json.hpp>

#include <highwall/internal/number_text.h>

#include "commands/dataset_report.h"
#include "files/json_text.h"

namespace highwall::apps {
namespace {

using Json = nlohmann::ordered_json;

Json StreamJson(const StreamReport& stream) {
  return {{"count", stream.count},
          {"duration", stream.duration},
          {"rate", stream.rate},
          {"gaps", stream.gaps},
          {"longest_interval", stream.longest_interval}};
}

Json ImuJson(const std::optional<ImuReport>& imu) {
  if (!imu) return nullptr;
  Json json = StreamJson(imu->stream);
  json["file"] = imu->file;
  json["usable"] = imu->usable;
  return json;
}

Json DepthJson(const DepthReport& depth, double factor) {
  const DepthStatistics& statistics = depth.statistics;
  Json json = {{"confidence", depth.Confidence()}, {"guesses", Json::array()}};
  constexpr std::size_t kMost = 3;
  for (std::size_t i = 0; i < std::min(kMost, depth.guesses.size()); ++i) {
    const DepthGuess& guess = depth.guesses[i];
    json["guesses"].push_back({{"sensor", guess.profile->name},
                               {"depth_factor", guess.depth_factor},
                               {"probability", guess.probability}});
  }
  json["quantiles_m"] = Json::array();
  for (const double quantile : statistics.quantiles) {
    json["quantiles_m"].push_back(quantile / factor);
  }
  json["nearest_m"] = statistics.nearest / factor;
  json["farthest_m"] = statistics.farthest / factor;
  json["holes"] = statistics.holes;
  json["edge_holes"] = statistics.edge_holes;
  json["corner_holes"] = statistics.corner_holes;
  json["left_holes"] = statistics.left_holes;
  json["unit_m"] = statistics.unit ? Json(*statistics.unit / factor) : Json(nullptr);
  json["inverse_step_per_m"] =
      statistics.inverse_step ? Json(*statistics.inverse_step * factor) : Json(nullptr);
  json["inverse_step_coherence"] = statistics.inverse_step_coherence;
  json["grain"] = Json::array();
  for (const DepthGrain& grain : statistics.grain) {
    json["grain"].push_back({{"depth_m", grain.depth / factor}, {"sigma_m", grain.sigma / factor}});
  }
  return json;
}

// Two lines.
std::string DepthText(const DepthReport& depth, double factor) {
  const DepthStatistics& statistics = depth.statistics;
  TextWriter text;
  text.precision(3);
  text << "  depth image   5 to 95% of the readings at " << statistics.quantiles.front() / factor
       << " to " << statistics.quantiles.back() / factor << " m; holes " << 100.0 * statistics.holes
       << "%, at the edges " << 100.0 * statistics.edge_holes << "%";
  if (statistics.inverse_step) {
    const double median = statistics.quantiles[2] / factor;
    text << "; steps of " << 1e3 * *statistics.inverse_step * factor * median * median
         << " mm at the median, growing as z^2";
  }
  if (!statistics.grain.empty()) {
    const auto most = std::ranges::max_element(statistics.grain, {}, &DepthGrain::patches);
    text << "; grain " << 1e3 * most->sigma / factor << " mm at " << most->depth / factor << " m";
  }
  text << "\n  depth sensor  ";
  if (depth.guesses.empty()) return text.str() + "unknown: the images do not reveal it\n";
  const DepthGuess& best = depth.guesses.front();
  text.precision(4);
  text << best.profile->name << " (" << best.profile->title << "), depth factor "
       << best.depth_factor << " (" << depth.Confidence() << ", " << 100.0 * best.probability
       << "%)\n";
  return text.str();
}

std::string StreamText(const StreamReport& stream) {
  TextWriter text;
  text.precision(1);
  text << std::fixed << stream.count << " in " << stream.duration << " s, " << stream.rate << "/s";
  return text.str();
}

}  // namespace

std::string ToJson(const DatasetReport& report) {
  Json json = {{"directory", report.directory.string()},
               {"format", report.format},
               {"topics", report.topics},
               {"frames", report.frames.count},
               {"usable_frames", report.usable_frames},
               {"association_rate", report.association_rate},
               {"duration", report.frames.duration},
               {"rate", report.frames.rate},
               {"gaps", report.frames.gaps},
               {"longest_interval", report.frames.longest_interval},
               {"colour", StreamJson(report.colour)},
               {"depth", StreamJson(report.depth)},
               {"width", report.width},
               {"height", report.height},
               {"depth_factor", report.depth_factor},
               {"median_depth", report.median_depth},
               {"measured_share", report.measured_share},
               {"depth_image", DepthJson(report.depth_images, report.depth_factor)},
               {"repeated_colour", report.repeated_colour},
               {"dark_colour", report.dark_colour},
               {"plain_colour", report.plain_colour},
               {"groundtruth", nullptr},
               {"imu", ImuJson(report.imu)},
               {"accelerometer", ImuJson(report.accelerometer)},
               {"calibration",
                {{"name", report.calibration.name},
                 {"confidence", report.calibration.confidence},
                 {"reason", report.calibration.reason}}},
               {"problems", report.problems}};
  if (report.groundtruth) {
    json["groundtruth"] = StreamJson(report.groundtruth->stream);
    json["groundtruth"]["path_length"] = report.groundtruth->path_length;
    json["groundtruth"]["frames_covered"] = report.groundtruth->frames_covered;
  }
  // File names need not be UTF-8; JSON must be.
  return JsonText(json, 2);
}

std::string ToText(const DatasetReport& report) {
  constexpr std::size_t kMaxProblems = 20;
  TextWriter text;
  text.precision(4);
  text << report.directory.string() << "\n"
       << "  format        " << report.format << "\n";
  if (!report.topics.empty()) text << "  topics        " << report.topics << "\n";
  text << "  frames        " << StreamText(report.frames) << "; " << report.usable_frames
       << " usable, " << report.width << " x " << report.height << "\n"
       << "  colour        " << StreamText(report.colour) << "\n"
       << "  depth         " << StreamText(report.depth) << "\n"
       << "  association   " << 100.0 * report.association_rate << "% of the colour images\n"
       << "  median depth  " << report.median_depth << " m with depth factor "
       << report.depth_factor << "; " << 100.0 * report.measured_share << "% of pixels measured\n"
       << DepthText(report.depth_images, report.depth_factor) << "  ground truth  ";
  if (report.groundtruth) {
    text << StreamText(report.groundtruth->stream) << ", " << report.groundtruth->path_length
         << " m, over " << 100.0 * report.groundtruth->frames_covered << "% of the frames\n";
  } else {
    text << "none\n";
  }
  text << "  IMU           ";
  if (report.imu) {
    text << report.imu->file << ": " << StreamText(report.imu->stream)
         << (report.imu->usable ? "" : "; cannot be used") << "\n";
  } else if (report.accelerometer) {
    text << "none (" << report.accelerometer->file << " alone: no gyroscope)\n";
  } else {
    text << "none\n";
  }
  text << "  calibration   "
       << (report.calibration.name.empty() ? "unknown" : report.calibration.name) << " ("
       << report.calibration.confidence << ": " << report.calibration.reason << ")\n";
  text << (report.problems.empty() ? "  no problems found\n" : "  problems:\n");
  const std::size_t shown = std::min(report.problems.size(), kMaxProblems);
  for (std::size_t i = 0; i < shown; ++i) text << "    " << report.problems[i] << "\n";
  if (shown < report.problems.size()) {
    text << "    and " << report.problems.size() - shown << " more (all with --json)\n";
  }
  return text.str();
}

}  // namespace highwall::apps
