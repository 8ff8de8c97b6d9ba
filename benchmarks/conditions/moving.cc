#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "bench_conditions.h"
#include "medians.h"
#include "runs.h"
#include "scenes.h"
#include "simulated_sequence.h"

namespace highwall::bench {
namespace {

SimulatedSequence SimulateScene(const std::string& scene, int seed, double seconds, bool traffic) {
  simulate::SimulationOptions options =
      scene == "room" ? SmallRoomOptions(seed, seconds) : SmallFieldTestOptions(seed, seconds);
  options.imu.enabled = false;
  options.traffic = traffic;
  return SimulatedSequence(Simulate(scene, options));
}

Scores RunOnce(const SimulatedSequence& sequence, bool set_aside) {
  SlamOptions slam;
  slam.tracker.moving.enabled = set_aside;
  const apps::SlamRun run = RunOver(sequence, slam, false);
  Scores scores = ScoreAll(sequence, run);
  scores["matched_points"] = run.matched_points;
  scores["matched_lines"] = run.matched_lines;
  return scores;
}

// Returns medians over the start frames; for lost frames the maximum.
Scores Run(const SimulatedSequence& sequence, int starts, bool set_aside) {
  HIGHWALL_REQUIRE(static_cast<std::size_t>(starts) < sequence.size(),
                   "--starts must leave two frames of the sequence, or --duration be longer");
  std::vector<Scores> runs;
  double lost = 0.0;
  for (int first = 0; first < starts; ++first) {
    runs.push_back(
        RunOnce(SimulatedSequence(sequence, static_cast<std::size_t>(first)), set_aside));
    lost = std::max(lost, runs.back().at("lost_frames"));
  }
  Scores scores = Medians(runs);
  scores["lost_frames"] = lost;
  return scores;
}

// Adds the change of the error relative to the static scene.
Scores Against(const Scores& still, Scores scores) {
  if (still.contains("ape_rmse_m") && scores.contains("ape_rmse_m")) {
    scores["ape_change_percent"] = 100.0 * (scores["ape_rmse_m"] / still.at("ape_rmse_m") - 1.0);
  }
  return scores;
}

}  // namespace

nlohmann::json BenchMoving(const ConditionOptions& options) {
  // Two laps in the room, so that the camera's path is the same with and without a visitor.
  constexpr double kSeconds = 24.0;
  Table table;
  for (const std::string& scene : options.scenes) {
    for (int seed = 1; seed <= options.seeds; ++seed) {
      const double seconds = options.seconds.value_or(kSeconds);
      // A visitor limits the camera to laps of 12 s (simulator.md).
      HIGHWALL_REQUIRE(scene != "room" || seconds <= 12.0 || (seconds > 20.0 && seconds <= 24.0),
                       "--duration of moving in the room must be up to 12, or 20 to 24 s: the "
                       "camera's path differs otherwise with and without a visitor");
      const Scores still = Run(SimulateScene(scene, seed, seconds, false), options.starts, true);
      table.Add(scene + ", still", seed, still);
      const SimulatedSequence sequence = SimulateScene(scene, seed, seconds, true);
      table.Add(scene + ", traffic", seed, Against(still, Run(sequence, options.starts, true)));
      table.Add(scene + ", traffic not masked out", seed,
                Against(still, Run(sequence, options.starts, false)));
    }
  }
  return table.ToJson();
}

}  // namespace highwall::bench
