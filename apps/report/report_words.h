#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// A run in words, a paragraph each: how much was tracked and how well, what the map came to, what
// the sensors turned out to be, how long it took. run: run.json, of a run or of runs that were
// merged; errors: ErrorsJson(), or null.
std::vector<std::string> SummaryInWords(const nlohmann::json& run, const nlohmann::json& errors);

}  // namespace highwall::apps
