#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace highwall::bench {

struct ConditionOptions {
  int seeds = 5;                                            // >= 1, of every scene
  std::vector<std::string> scenes{"mine", "road", "room"};  // only those that a part supports apply
  std::optional<double> seconds;                            // > 0 [s]; default: that of each part
  int starts = 3;          // >= 1: runs of a sequence of BenchMoving, each starting a frame later
  double contrast = 0.5;   // (0, 1]: remaining contrast in the stretch of low texture
  double too_long = 1.04;  // > 0: measured over true depth
};

// Compares scenes with and without traffic, with and without masking out dynamic objects. The error
// of one sequence varies by 20 % with the start frame: the result is the median of `starts` runs.
nlohmann::json BenchMoving(const ConditionOptions& options);

// Compares configurations on a stretch of the road with low image contrast.
nlohmann::json BenchTexture(const ConditionOptions& options);

// Does the same for a stretch of the mine in deep shadow.
nlohmann::json BenchDark(const ConditionOptions& options);

// Estimates the depth scale with the IMU, from depth that is too long and from correct depth.
nlohmann::json BenchDepth(const ConditionOptions& options);

}  // namespace highwall::bench
