#pragma once

#include <filesystem>

namespace highwall::apps {

// In the folder that a command writes to (FolderLock). One that was killed leaves it there: what
// else is in the folder is of Highwall then.
inline constexpr const char* kLockFile = ".highwall.lock";

// What a folder for results holds. What is hidden counts for nothing: no command touches it.
enum class FolderContent {
  kNothing,     // or the folder is not there
  kRun,         // of highwall slam or merge, whole or killed
  kMaps,        // of highwall map, whole
  kUnfinished,  // what a command of Highwall left that was killed
  kForeign,     // or the folder cannot be listed
};
FolderContent ContentOf(const std::filesystem::path& folder);

}  // namespace highwall::apps
