#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "slam_run.h"

namespace highwall::apps {

// {"mean":..., "median":..., "p95":..., "count":...} in milliseconds.
nlohmann::json ToJson(const Milliseconds& milliseconds);
nlohmann::json ToJson(const StageTimes& times);
// What a run was told to do, as far as it shapes the result.
nlohmann::json ToJson(const SlamRunOptions& options);
// Versions of Highwall and of the libraries that it computes with.
nlohmann::json VersionsJson();
// All of run.json but the map.
nlohmann::json RunJson(const SlamRun& run, const SlamRunOptions& options,
                       const std::string& dataset, const std::string& calibration);

// trajectory.txt, trajectory_causal.txt, keyframes.txt, run.json, where the run has them
// trajectory_adjusted.txt and, of a dense map, cloud.ply, map.bt, grid.pgm and grid.yaml. The
// folder is made where it is missing; each file is replaced whole, and maps of an earlier run that
// this one does not replace are removed. Returns what run.json says: run_json and the sizes of the
// map. Throws IoError.
nlohmann::json WriteRun(const std::filesystem::path& directory, const SlamRun& run,
                        const nlohmann::json& run_json);

}  // namespace highwall::apps
