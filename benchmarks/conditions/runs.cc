#include "runs.h"

#include <cmath>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>

#include "scenes.h"

namespace highwall::bench {
namespace {

// Prints one line on standard error.
void Tell(const std::string& name, int seed, const Scores& scores) {
  std::string line = fmt::format("{} {}:", name, seed);
  for (const auto& [figure, value] : scores) line += fmt::format(" {} {:.4g}", figure, value);
  fmt::print(stderr, "{}\n", line);
}

}  // namespace

apps::SlamRun RunOver(const SimulatedSequence& sequence, const SlamOptions& slam, bool imu) {
  apps::SlamRunOptions options;
  options.slam = Deterministic(slam);
  options.dense = false;
  options.prefetch = 0;
  if (imu) options.imu = sequence.imu();
  apps::SlamRun run = apps::RunSlam(sequence, sequence.sensor(), options);
  apps::RequireWhole(run);
  return run;
}

Scores ScorePart(const SimulatedSequence& sequence, const apps::SlamRun& run, Stamp begin,
                 Stamp end) {
  const Trajectory truth = Between(*sequence.groundtruth(), begin, end);
  const Trajectory estimate = Between(run.largest.trajectory, begin, end);
  Scores scores;
  scores["lost_frames"] = static_cast<double>(truth.size()) - static_cast<double>(estimate.size());
  const double interval = ToSeconds(sequence.stamp(1) - sequence.stamp(0));
  try {
    scores["ape_rmse_m"] = AbsolutePoseError(truth, estimate).statistics.rmse;
    scores["rpe_1s_rmse_m"] =
        RelativePoseError(truth, estimate, {.delta = std::round(1.0 / interval), .all_pairs = true})
            .statistics.rmse;
  } catch (const InvalidArgument&) {  // too few poses
  }
  return scores;
}

Scores ScoreAll(const SimulatedSequence& sequence, const apps::SlamRun& run) {
  return ScorePart(sequence, run, sequence.stamp(0), sequence.stamp(sequence.size() - 1));
}

void Table::Add(const std::string& name, int seed, Scores scores) {
  Tell(name, seed, scores);
  scores["seed"] = seed;
  runs_[name].push_back(std::move(scores));
}

nlohmann::json Table::ToJson() const {
  nlohmann::json json;
  for (const auto& [name, runs] : runs_) {
    Scores medians = Medians(runs);
    medians.erase("seed");
    json[name] = {{"median", medians}, {"runs", runs}};
  }
  return json;
}

}  // namespace highwall::bench
