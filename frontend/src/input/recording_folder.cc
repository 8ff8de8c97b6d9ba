#include "input/recording_folder.h"

#include <system_error>

#include <highwall/core/error.h>

namespace highwall {

void RequireRecordingFolder(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::exists(folder, error)) throw IoError(folder, "does not exist");
  if (!std::filesystem::is_directory(folder, error)) {
    throw IoError(folder, "is not a directory, and no .bag, .db3 or .mcap of ROS");
  }
  if (std::filesystem::is_empty(folder, error)) throw IoError(folder, "is empty");
}

}  // namespace highwall
