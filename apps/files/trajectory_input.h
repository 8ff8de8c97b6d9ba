#pragma once

#include <filesystem>
#include <string>

#include <highwall/core/trajectory.h>

namespace highwall::apps {

// Reads any format of ReadTrajectoryFile() that has stamps. Assumptions are printed as a warning of
// `command`. Throws as that function, and IoError for a file without stamps.
Trajectory ReadStampedPoses(const std::string& command, const std::filesystem::path& path);

}  // namespace highwall::apps
