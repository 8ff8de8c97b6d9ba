#pragma once

#include <filesystem>
#include <string>

#include <highwall/core/trajectory.h>

namespace highwall::apps {

// Of any form that ReadTrajectoryFile() reads and that has stamps. What had to be assumed is
// printed as a warning of `command`. Throws as that does, and IoError for a file without stamps.
Trajectory ReadStampedPoses(const std::string& command, const std::filesystem::path& path);

}  // namespace highwall::apps
