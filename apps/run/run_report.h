#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "run/slam_run.h"

namespace highwall::apps {

// Returns {"mean":..., "median":..., "p95":..., "p99":..., "worst":..., "count":...} in
// milliseconds.
nlohmann::json ToJson(const TimingStatistics& milliseconds);
nlohmann::json ToJson(const StageTimes& times);
// Returns the absolute file name for a report, which may be read from another folder; empty if
// `path` is empty.
std::string AbsoluteName(const std::filesystem::path& path);
// Returns the options of a run that affect its result.
nlohmann::json ToJson(const SlamRunOptions& options);
// Converts the noise model to JSON and back; the default is a Kinect's if the report has none.
nlohmann::json ToJson(const DepthNoise& noise);
DepthNoise DepthNoiseOf(const nlohmann::json& report);
// Returns the versions of Highwall and of its numerical libraries.
nlohmann::json VersionsJson();
// Returns the part of run.json about the run itself; RunOutput adds the rest.
nlohmann::json RunJson(const SlamRun& run, const SlamRunOptions& options,
                       const std::string& dataset, const std::string& calibration);

}  // namespace highwall::apps
