#include <algorithm>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "bench_loops.h"
#include "loops/loop_closer.h"
#include "support/loop_scene.h"
#include "timing.h"

namespace highwall::bench {
namespace {

struct Closed {
  bool accepted = false;
  std::size_t keyframes = 0, points = 0, lines = 0;
  double corrected_s = 0.0, adjusted_s = 0.0, caller_s = 0.0;  // caller: the longest call
  double rmse_before = 0.0, rmse_after = 0.0;                  // [m]
};

// Closes a loop on a walk of a quarter of a metre per keyframe with odometry drift; about 300
// points and 30 lines per keyframe.
Closed CloseLoop(int keyframes, unsigned seed) {
  testing::LoopScene scene({.per_lap = keyframes,
                            .points = 25 * keyframes,
                            .lines = 3 * keyframes,
                            .odometry = testing::OdometryDrift{.seed = seed},
                            .seed = seed});
  LoopCloser closer(scene.model);
  Closed closed;
  for (int i = 0; i < scene.size(); ++i) {
    const KeyFrameId id = scene.Add(i);
    bool found = false;
    const double seconds = WallSeconds([&] { found = closer.InsertKeyFrame(scene.map, id); });
    closed.caller_s = std::max(closed.caller_s, seconds);
    if (found) break;
  }
  closed.rmse_before = scene.Rmse();
  std::vector<LoopReport> reports;
  closed.adjusted_s = WallSeconds([&] { reports = closer.Finish(&scene.map); });
  closed.accepted = reports.size() == 2 && reports[0].accepted;
  if (closed.accepted) closed.corrected_s = reports[0].seconds;
  closed.rmse_after = scene.Rmse();
  closed.keyframes = scene.map.num_keyframes();
  closed.points = scene.map.num<MapPoint>();
  closed.lines = scene.map.num<MapLine>();
  return closed;
}

// Median and maximum.
template <class Value>
nlohmann::json Spread(const std::vector<Closed>& runs, Value value) {
  std::vector<double> values;
  for (const Closed& run : runs) values.push_back(value(run));
  std::sort(values.begin(), values.end());
  return {{"median", values[values.size() / 2]}, {"worst", values.back()}};
}

}  // namespace

nlohmann::json BenchCorrection(int keyframes, int seeds) {
  nlohmann::json rows = nlohmann::json::array();
  constexpr int kFewest = 48;  // minimum per lap
  for (const int part : {8, 4, 2, 1}) {
    const int per_lap = std::max(kFewest, keyframes / part);
    if (per_lap == kFewest && part > 1) continue;
    std::vector<Closed> runs;
    for (int seed = 1; seed <= seeds; ++seed) {
      runs.push_back(CloseLoop(per_lap, static_cast<unsigned>(seed)));
    }
    const auto accepted =
        std::count_if(runs.begin(), runs.end(), [](const Closed& run) { return run.accepted; });
    const auto before = Spread(runs, [](const Closed& run) { return run.rmse_before; });
    const auto after = Spread(runs, [](const Closed& run) { return run.rmse_after; });
    const auto corrected = Spread(runs, [](const Closed& run) { return run.corrected_s; });
    const auto adjusted = Spread(runs, [](const Closed& run) { return run.adjusted_s; });
    const auto caller = Spread(runs, [](const Closed& run) { return run.caller_s; });
    const auto of = [](const nlohmann::json& spread, const char* which) {
      return spread[which].get<double>();
    };
    fmt::print(
        stderr,
        "{} keyframes, {} points, {} lines: closed in {} of {} walks; RMSE {:.3f} ({:.3f} "
        "at worst) -> {:.3f} ({:.3f}) m; map corrected after {:.2f} s, adjusted after {:.2f} "
        "s; at most {:.1f} ms of the caller's time\n",
        runs.back().keyframes, runs.back().points, runs.back().lines, accepted, runs.size(),
        of(before, "median"), of(before, "worst"), of(after, "median"), of(after, "worst"),
        of(corrected, "median"), of(adjusted, "median"), 1e3 * of(caller, "worst"));
    rows.push_back({{"keyframes", runs.back().keyframes},
                    {"points", runs.back().points},
                    {"lines", runs.back().lines},
                    {"walks", runs.size()},
                    {"closed", accepted},
                    {"rmse_before_m", before},
                    {"rmse_after_m", after},
                    {"corrected_s", corrected},
                    {"adjusted_s", adjusted},
                    {"caller_s", caller}});
  }
  return rows;
}

}  // namespace highwall::bench
