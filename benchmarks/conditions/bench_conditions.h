#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace highwall::bench {

struct ConditionOptions {
  int seeds = 5;                                            // >= 1, of every scene
  std::vector<std::string> scenes{"mine", "road", "room"};  // of those that a part knows
  std::optional<double> seconds;                            // > 0 [s]; of each part else its own
  int starts = 3;  // >= 1: runs of a sequence of BenchMoving, each a frame later than the last
  double contrast = 0.5;   // (0, 1]: share that the stretch of low texture keeps
  double too_long = 1.04;  // > 0: measured over true depth
};

// Scenes with traffic and without: what it changes, with moving objects set aside and not. The
// error of one sequence scatters by 20 % with the frame where it begins: of each, medians of
// `starts`.
nlohmann::json BenchMoving(const ConditionOptions& options);

// A stretch of the road whose images have little contrast: who crosses it, with what.
nlohmann::json BenchTexture(const ConditionOptions& options);

// A stretch of the mine in deep shadow, likewise.
nlohmann::json BenchDark(const ConditionOptions& options);

// Depth that reads too long, and as it should: the scale that the IMU tells.
nlohmann::json BenchDepth(const ConditionOptions& options);

}  // namespace highwall::bench
