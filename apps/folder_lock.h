#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <highwall/core/file_lock.h>

#include "folder_content.h"

namespace highwall::apps {

// Keeps other commands of Highwall from writing to a folder while this lives. It dies with the
// process.
class FolderLock {
 public:
  // Makes the folder where it is missing. Throws IoError where another command holds it, or where
  // it cannot be made or written to.
  explicit FolderLock(std::filesystem::path folder);
  // Removes its file, unless that alone shows what unfinished results are, and the folders that it
  // made, as far as they are empty.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  void MakeFolder();

  std::filesystem::path folder_;
  FolderContent before_;
  std::vector<std::filesystem::path> made_;  // outer ones first
  std::optional<FileLock> lock_;
};

}  // namespace highwall::apps
