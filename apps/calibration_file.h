#pragma once

#include <filesystem>

#include "config.h"

namespace highwall::apps {

// A configuration that LoadConfig() reads back exactly. Written whole or not at all. Throws
// IoError.
void WriteConfig(const std::filesystem::path& path, const RunConfig& config);

}  // namespace highwall::apps
