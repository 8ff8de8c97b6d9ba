#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// Returns a table with a line for each cause: its value with two standard deviations, the residual
// error without it, and the share of the error that it explains.
std::string ExplanationTable(const ErrorExplanation& explanation);

nlohmann::ordered_json ToJson(const ErrorExplanation& explanation);

}  // namespace highwall::apps
