#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "report/report_scene.h"

namespace highwall::apps {

struct RunDataOptions {
  std::optional<std::filesystem::path> truth;  // empty: groundtruth.txt of the run's dataset
  SceneLimits scene;
  std::size_t samples = 6'000;  // of each curve
};

// Returns all data of a run for the page, from its folder (page/report.js reads it):
//   "name", "folder", "words" (SummaryInWords)
//   "run": run.json without per-frame data
//   "path": PathJson of the largest map; "errors": ErrorsJson, or null without a truth at hand
//   "maps": {"name", "frames", "keyframes", "spans": [[first, last] s]} of each map
//   "lost": {"t" [s], "because"} of each frame without a pose
//   "frames": {"t", "points", "lines", "milliseconds"}, or null
//   "imu": {"t", "weight", "innovation", "states": {"t", "gyroscope_bias", ...}}, or null
//   "graph": GraphJson, "loops": LoopsJson, "scene": SceneJson
//   "pictures": {"name", "of", "src": a data URI}
// Seconds are relative to the first frame. Throws IoError as ReadReport(), and for damaged files.
nlohmann::json RunData(const std::filesystem::path& folder, const RunDataOptions& options);

}  // namespace highwall::apps
