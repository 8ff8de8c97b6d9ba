#include "files/trajectory_input.h"

#include <utility>

#include <highwall/core/error.h>

#include "cli/commands.h"
#include "files/trajectory_file.h"

namespace highwall::apps {

Trajectory ReadStampedPoses(const std::string& command, const std::filesystem::path& path) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (!HasStamps(file.format)) {
    throw IoError(path, "holds matrices without stamps: poses with stamps are needed here");
  }
  if (!file.assumed.empty()) PrintWarning(command, path.string() + ": " + file.assumed);
  return std::move(file.poses);
}

}  // namespace highwall::apps
