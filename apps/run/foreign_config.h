#pragma once

#include <string>

#include "run/config.h"

// Configurations from files of other systems, which state less than calibration.yaml
// (SensorCalibration::format, SensorCalibration::defaults).
namespace highwall::apps {

// Takes what the file does not state from `own`, the configuration that the recording has without
// it; own_origin: human-readable. The note of the result says so in one line.
ResolvedConfig CompletedBy(const RunConfig& own, const std::string& own_origin,
                           const ResolvedConfig& foreign);

// Returns the note of a file of which nothing completes the defaults; empty for calibration.yaml.
std::string NoteOfDefaults(const ResolvedConfig& config);

}  // namespace highwall::apps
