#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// A table with a line for each cause: its value with two standard deviations, what is left without
// it, and the share of the error that it takes away.
std::string ExplanationTable(const ErrorExplanation& explanation);

nlohmann::ordered_json ToJson(const ErrorExplanation& explanation);

}  // namespace highwall::apps
