#pragma once

#include <filesystem>
#include <string>

#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// Labels of a result in evo's tables and plots.
struct EvoResultInfo {
  std::string title;      // such as "APE w.r.t. translation part (m)"
  std::string label;      // such as "APE (m)"
  std::string reference;  // file names
  std::string estimate;
};

// Writes a result in the format that evo_ape and evo_rpe save with --save_results: a zip with
// info.json, stats.json, error_array.npy, timestamps.npy, seconds_from_start.npy and both
// trajectories in TUM format, the estimate aligned. evo_res compares such files. Throws IoError.
void WriteEvoResult(const std::filesystem::path& path, const EvoResultInfo& info,
                    const TrajectoryError& result);

}  // namespace highwall::apps
