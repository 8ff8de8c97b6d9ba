#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/trajectory_error.h>

#include "overlay_plot.h"

namespace highwall::apps {

// {"stats", "associated", "time_covered", "scale"}, and "undetermined" where the alignment is not.
nlohmann::ordered_json ErrorJson(const TrajectoryError& error);

// What of the alignment is not determined, and what was done about it; empty where all of it is.
std::string OpenRotationText(OpenRotation open);

// A title and a row for each estimate, as RFC 4180 has it.
std::string ErrorsCsv(const std::vector<NamedError>& errors);

// The same as text, in columns; of several estimates the least RMSE has a star.
std::string ErrorsTable(const std::vector<NamedError>& errors);

}  // namespace highwall::apps
