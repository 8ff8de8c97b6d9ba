#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

// Resolves the files that a run names in its run.json. Older versions wrote names as given,
// relative to a folder that the report does not contain: these are searched for next to the run, in
// its parent folders, and in the current folder.

// Returns the options with which the run with this run.json read its recording; the defaults for
// those that it does not state.
DatasetOptions InputOptionsOfRun(const nlohmann::json& report);

// Returns the existing files or folders that `name` may refer to, without duplicates.
std::vector<std::filesystem::path> PlacesOf(const std::filesystem::path& name,
                                            const std::filesystem::path& run);

// Returns the candidate recordings of the run: a relative name is accepted only if the recording
// contains all frames of the run. Empty if there is none, or if the report names none.
std::vector<std::filesystem::path> DatasetsOfRun(const std::filesystem::path& run,
                                                 const nlohmann::json& report);

// Returns the calibration of a run, as --config takes it; empty if it is the dataset's own.
std::string CalibrationOfRun(const std::filesystem::path& run, const nlohmann::json& report);

}  // namespace highwall::apps
