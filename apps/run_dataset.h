#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// What a run names in its run.json lies where it says. Older versions wrote names as they were
// given, relative to a folder that the report does not tell: then it is what lies beside the run or
// a folder above it, or here.

// The files or folders that `name` may stand for, each once.
std::vector<std::filesystem::path> PlacesOf(const std::filesystem::path& name,
                                            const std::filesystem::path& run);

// The recordings that the run may be of: a relative name counts where all frames of the run are in
// what it leads to. Empty where there is none, or where the report names none.
std::vector<std::filesystem::path> DatasetsOfRun(const std::filesystem::path& run,
                                                 const nlohmann::json& report);

// The calibration of a run, as --config takes it; empty where that of the dataset counts.
std::string CalibrationOfRun(const std::filesystem::path& run, const nlohmann::json& report);

}  // namespace highwall::apps
