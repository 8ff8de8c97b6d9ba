#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/trajectory_error.h>

#include "plots/overlay_plot.h"

namespace highwall::apps {

// Returns {"stats", "associated", "time_covered", "scale"}, and "undetermined" if the alignment is
// unobservable in part.
nlohmann::ordered_json ErrorJson(const TrajectoryError& error);

// Describes the unobservable part of the alignment and how it was handled; empty if fully
// observable.
std::string OpenRotationText(OpenRotation open);

// Returns CSV (RFC 4180) with a header and a row for each estimate.
std::string ErrorsCsv(const std::vector<NamedError>& errors);

// Returns the same as an aligned text table; of several estimates the least RMSE has a star.
std::string ErrorsTable(const std::vector<NamedError>& errors);

}  // namespace highwall::apps
