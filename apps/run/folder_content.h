#pragma once

#include <filesystem>

namespace highwall::apps {

// Lock file in the output folder of a command (FolderLock). A killed command leaves it behind,
// which marks the rest of the folder as Highwall's.
inline constexpr const char* kLockFile = ".highwall.lock";

// Content of an output folder. Hidden files are ignored: no command touches them.
enum class FolderContent {
  kNothing,     // or the folder does not exist
  kRun,         // of highwall slam or merge, complete or killed
  kMaps,        // of highwall map, complete
  kUnfinished,  // left by a killed command of Highwall
  kForeign,     // or the folder cannot be listed
};
FolderContent ContentOf(const std::filesystem::path& folder);

}  // namespace highwall::apps
