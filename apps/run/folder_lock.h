#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <highwall/core/file_lock.h>

#include "run/folder_content.h"

namespace highwall::apps {

// Prevents other commands of Highwall from writing to a folder during its lifetime. The lock is
// released when the process dies.
class FolderLock {
 public:
  // Creates a missing folder. Throws IoError if another command holds the lock, or if the folder
  // cannot be created or written to.
  explicit FolderLock(std::filesystem::path folder);
  // Removes the lock file, unless it alone marks unfinished results, and the folders that the
  // constructor created, if they are empty.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  void MakeFolder();

  std::filesystem::path folder_;
  FolderContent before_;
  std::vector<std::filesystem::path> made_;  // outermost first
  std::optional<FileLock> lock_;
};

}  // namespace highwall::apps
