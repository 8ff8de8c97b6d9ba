#include <string>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "bench_conditions.h"
#include "film.h"
#include "runs.h"
#include "scenes.h"

namespace highwall::bench {
namespace {

Film FilmScene(const std::string& scene, int seed, double seconds, bool traffic) {
  simulate::SimulationOptions options =
      scene == "room" ? SmallRoomOptions(seed, seconds) : SmallFieldTestOptions(seed, seconds);
  options.imu.enabled = false;
  options.traffic = traffic;
  return Film(Simulate(scene, options));
}

Scores Run(const Film& film, bool set_aside) {
  SlamOptions slam;
  slam.tracker.moving.enabled = set_aside;
  const apps::SlamRun run = RunOver(film, slam, false);
  Scores scores = ScoreAll(film, run);
  scores["matched_points"] = run.matched_points;
  scores["matched_lines"] = run.matched_lines;
  return scores;
}

// Adds by how much the error differs from that of the still scene.
Scores Against(const Scores& still, Scores scores) {
  if (still.contains("ape_rmse_m") && scores.contains("ape_rmse_m")) {
    scores["ape_change_percent"] = 100.0 * (scores["ape_rmse_m"] / still.at("ape_rmse_m") - 1.0);
  }
  return scores;
}

}  // namespace

nlohmann::json BenchMoving(const ConditionOptions& options) {
  // In the room two laps, so that the camera's path is the same with and without a visitor.
  constexpr double kSeconds = 24.0;
  Table table;
  for (const std::string& scene : options.scenes) {
    for (int seed = 1; seed <= options.seeds; ++seed) {
      const double seconds = options.seconds.value_or(kSeconds);
      // The visitor leaves the camera laps of 12 s at most (simulator.md).
      HIGHWALL_REQUIRE(scene != "room" || seconds <= 12.0 || (seconds > 20.0 && seconds <= 24.0),
                       "--duration of moving in the room must be up to 12, or 20 to 24 s: the "
                       "camera's path differs otherwise with and without a visitor");
      const Scores still = Run(FilmScene(scene, seed, seconds, false), true);
      table.Add(scene + ", still", seed, still);
      const Film film = FilmScene(scene, seed, seconds, true);
      table.Add(scene + ", traffic", seed, Against(still, Run(film, true)));
      table.Add(scene + ", traffic not set aside", seed, Against(still, Run(film, false)));
    }
  }
  return table.ToJson();
}

}  // namespace highwall::bench
