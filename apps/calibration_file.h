#pragma once

#include <filesystem>

#include "config.h"

namespace highwall::apps {

// A configuration that LoadConfig() reads back, exactly but for the rotation of T_BC (to 1e-15).
// timing_sigma [s]: of the times of the rows, those above 0 are told beside them.
// Written whole or not at all, its folder made where it is missing. Throws IoError.
void WriteConfig(const std::filesystem::path& path, const RunConfig& config,
                 const FrameTiming& timing_sigma = {});

}  // namespace highwall::apps
