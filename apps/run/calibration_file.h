#pragma once

#include <filesystem>
#include <string>

#include "run/config.h"

namespace highwall::apps {

// Standard deviations of the calibrated values; 0 for values that were not estimated.
struct CalibrationSigma {
  FrameTiming timing;                 // [s]
  double inverse_depth_offset = 0.0;  // [1/m]
  double depth_pattern = 0.0;         // [1/m] RMS over the nodes
};

// Writes a configuration that ReadSensor() reads back exactly, except for the rotation of T_BC (to
// 1e-15). Standard deviations above 0 are written as comments next to their values, and so is
// `depth_factor_comment`, unless it is empty. The file is written atomically; a missing folder is
// created. Throws IoError.
void WriteConfig(const std::filesystem::path& path, const RunConfig& config,
                 const CalibrationSigma& sigma = {}, const std::string& depth_factor_comment = "");

}  // namespace highwall::apps
