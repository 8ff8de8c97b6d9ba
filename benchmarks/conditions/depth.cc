#include <cmath>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "bench_conditions.h"
#include "runs.h"
#include "scenes.h"
#include "simulated_sequence.h"

namespace highwall::bench {
namespace {

// too_long: measured over true depth.
Scores FindScale(const SimulatedSequence& sequence, double too_long) {
  const apps::SlamRun run = RunOver(sequence, {}, true);
  Scores scores = ScoreAll(sequence, run);
  if (!run.inertial || !run.inertial->depth_scale) return scores;
  const DepthScale& found = *run.inertial->depth_scale;
  scores["scale"] = found.scale;
  scores["sigma"] = found.sigma;
  scores["error_sigmas"] = std::abs(found.scale - 1.0 / too_long) / found.sigma;
  return scores;
}

}  // namespace

nlohmann::json BenchDepth(const ConditionOptions& options) {
  constexpr double kSeconds = 30.0;
  Table table;
  for (const std::string& scene : options.scenes) {
    if (scene == "mine") continue;
    for (int seed = 1; seed <= options.seeds; ++seed) {
      const double seconds = options.seconds.value_or(kSeconds);
      SimulatedSequence sequence(Simulate(scene, scene == "room"
                                                     ? SmallRoomOptions(seed, seconds)
                                                     : SmallFieldTestOptions(seed, seconds)));
      table.Add(scene + ", depth as it is", seed, FindScale(sequence, 1.0));
      sequence.ScaleDepth(options.too_long);
      table.Add(fmt::format("{}, depth times {:g}", scene, options.too_long), seed,
                FindScale(sequence, options.too_long));
    }
  }
  return table.ToJson();
}

}  // namespace highwall::bench
