#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <simulate/scenes/haul_road.h>

#include "bench_conditions.h"
#include "film.h"
#include "runs.h"
#include "scenes.h"

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

simulate::Stretch LowTextureOf(const simulate::SimulationOptions& road) {
  const std::vector<simulate::Stretch> stretches = simulate::RoadStretches(road);
  const auto found =
      std::ranges::find(stretches, simulate::StretchKind::kLowTexture, &simulate::Stretch::kind);
  HIGHWALL_REQUIRE(found != stretches.end(), "the film ends before the stretch of low texture");
  return *found;
}

}  // namespace

nlohmann::json BenchTexture(const ConditionOptions& options) {
  constexpr double kSeconds = 33.0, kBefore = 3.0;  // [s]
  Table table;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    simulate::SimulationOptions road =
        SmallFieldTestOptions(seed, options.seconds.value_or(kSeconds));
    road.fps = 15.0;
    road.low_texture_contrast = options.contrast;
    const simulate::Stretch stretch = LowTextureOf(road);
    const simulate::Simulation simulation = Simulate("road", road);
    const Film film(simulation, stretch.begin - kBefore);
    const Stamp start = simulation.StampOf(0);
    for (const Uses& uses : kUses) {
      SlamOptions slam;
      slam.frame.use_lines = uses.lines;
      slam.tracker.surfaces.enabled = uses.planes;
      table.Add(uses.name, seed,
                ScorePart(film, RunOver(film, slam, false), start + FromSeconds(stretch.begin),
                          start + FromSeconds(stretch.end)));
    }
  }
  return table.ToJson();
}

}  // namespace highwall::bench
