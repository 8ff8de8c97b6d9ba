#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// Returns a summary of a run in paragraphs: tracking, accuracy, map, sensor calibration, and time.
// run: run.json of a single or merged run; errors: ErrorsJson(), or null.
std::vector<std::string> SummaryInWords(const nlohmann::json& run, const nlohmann::json& errors);

}  // namespace highwall::apps
