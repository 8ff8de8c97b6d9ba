#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <simulate/scenes/haul_road.h>
#include <simulate/scenes/mine.h>

#include "bench_conditions.h"
#include "runs.h"
#include "scenes.h"
#include "simulated_sequence.h"

namespace highwall::bench {
namespace {

struct Uses {
  const char* name;
  bool lines, planes;
};

constexpr Uses kUses[] = {{"points", false, false},
                          {"points, planes", false, true},
                          {"points, lines", true, false},
                          {"points, lines, planes", true, true}};

simulate::Stretch Find(simulate::StretchKind kind,
                       const std::vector<simulate::Stretch>& stretches) {
  const auto found = std::ranges::find(stretches, kind, &simulate::Stretch::kind);
  HIGHWALL_REQUIRE(found != stretches.end(),
                   "the sequence ends before the stretch of " + std::string(ToString(kind)));
  return *found;
}

// Runs from kBefore before the stretch, and scores within it.
nlohmann::json CrossStretch(const ConditionOptions& options, const std::string& scene,
                            double seconds, simulate::StretchKind kind) {
  constexpr double kBefore = 3.0;  // [s]
  Table table;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    simulate::SimulationOptions field =
        SmallFieldTestOptions(seed, options.seconds.value_or(seconds));
    field.fps = 15.0;
    field.low_texture_contrast = options.contrast;
    const simulate::Stretch stretch = Find(
        kind, scene == "mine" ? simulate::MineStretches(field) : simulate::RoadStretches(field));
    const simulate::Simulation simulation = Simulate(scene, field);
    const SimulatedSequence sequence(simulation, stretch.begin - kBefore);
    const Stamp start = simulation.StampOf(0);
    for (const Uses& uses : kUses) {
      SlamOptions slam;
      slam.frame.use_lines = uses.lines;
      slam.tracker.surfaces.enabled = uses.planes;
      table.Add(uses.name, seed,
                ScorePart(sequence, RunOver(sequence, slam, false),
                          start + FromSeconds(stretch.begin), start + FromSeconds(stretch.end)));
    }
  }
  return table.ToJson();
}

}  // namespace

nlohmann::json BenchTexture(const ConditionOptions& options) {
  return CrossStretch(options, "road", 33.0, simulate::StretchKind::kLowTexture);
}

nlohmann::json BenchDark(const ConditionOptions& options) {
  return CrossStretch(options, "mine", 45.0, simulate::StretchKind::kLowLight);
}

}  // namespace highwall::bench
