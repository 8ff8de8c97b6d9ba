#include "bench_loops.h"

#include <algorithm>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/loop_closer.h>

#include "loop_scene.h"
#include "timing.h"

namespace highwall::bench {
nlohmann::json BenchCorrection(int keyframes) {
  // A walk of a quarter of a metre a keyframe that comes back with a drift of half a percent; some
  // 300 points and 30 lines a keyframe.
  const int per_lap = std::max(48, keyframes);
  testing::LoopScene scene({.per_lap = per_lap,
                            .points = 25 * per_lap,
                            .lines = 3 * per_lap,
                            .drift = {0.001, 0.0003, 0.0}});
  LoopCloser closer(scene.model, testing::kLevels);
  double worst_caller_ms = 0.0;
  int i = 0;
  for (bool found = false; !found && i < scene.size(); ++i) {
    const KeyFrameId id = scene.Add(i);
    const double seconds = WallSeconds([&] { found = closer.InsertKeyFrame(scene.map, id); });
    worst_caller_ms = std::max(worst_caller_ms, 1e3 * seconds);
  }
  const double drifted = scene.Rmse();
  std::vector<LoopReport> reports;
  const double seconds = WallSeconds([&] { reports = closer.Finish(&scene.map); });
  if (reports.size() != 2 || !reports[0].accepted) throw InvalidArgument("the loop was not closed");
  fmt::print(
      stderr,
      "{} keyframes, {} points, {} lines: map corrected after {:.2f} s, adjusted after {:.2f} "
      "s; RMSE {:.3f} -> {:.3f} m; at most {:.1f} ms of the caller's time\n",
      scene.map.num_keyframes(), scene.map.num_points(), scene.map.num_lines(), reports[0].seconds,
      seconds, drifted, scene.Rmse(), worst_caller_ms);
  return {{"keyframes", scene.map.num_keyframes()},
          {"points", scene.map.num_points()},
          {"lines", scene.map.num_lines()},
          {"corrected_s", reports[0].seconds},
          {"adjusted_s", seconds},
          {"rmse_before_m", drifted},
          {"rmse_after_m", scene.Rmse()},
          {"worst_caller_ms", worst_caller_ms}};
}

}  // namespace highwall::bench
