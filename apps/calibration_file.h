#pragma once

#include <filesystem>

#include "config.h"

namespace highwall::apps {

// Standard deviations of what a calibration has found; 0 of what it has not.
struct CalibrationSigma {
  FrameTiming timing;                 // [s]
  double inverse_depth_offset = 0.0;  // [1/m]
  double depth_pattern = 0.0;         // [1/m] root mean square over its nodes
};

// A configuration that LoadConfig() reads back, exactly but for the rotation of T_BC (to 1e-15).
// Deviations above 0 are told beside what they are of.
// Written whole or not at all, its folder made where it is missing. Throws IoError.
void WriteConfig(const std::filesystem::path& path, const RunConfig& config,
                 const CalibrationSigma& sigma = {});

}  // namespace highwall::apps
