#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "slam_run.h"

namespace highwall::apps {

// {"mean":..., "median":..., "p95":..., "count":...} in milliseconds.
nlohmann::json ToJson(const Milliseconds& milliseconds);
nlohmann::json ToJson(const StageTimes& times);
// As reports name files, which are read from other folders; empty where there is none.
std::string AbsoluteName(const std::filesystem::path& path);
// What a run was told to do, as far as it shapes the result.
nlohmann::json ToJson(const SlamRunOptions& options);
// The fields of the noise, and back; a Kinect's where the report does not say.
nlohmann::json ToJson(const DepthNoise& noise);
DepthNoise DepthNoiseOf(const nlohmann::json& report);
// Versions of Highwall and of the libraries that it computes with.
nlohmann::json VersionsJson();
// What run.json says of the run itself; RunOutput adds the rest.
nlohmann::json RunJson(const SlamRun& run, const SlamRunOptions& options,
                       const std::string& dataset, const std::string& calibration);

}  // namespace highwall::apps
