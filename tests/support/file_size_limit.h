#pragma once

#include <sys/resource.h>

#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"

namespace highwall::testing {

// During its lifetime no file of this process can grow beyond `bytes`, which simulates a full disk
// for a writer.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_limit_);
    const rlimit limit{bytes, old_limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*old_handler_)(int);
  rlimit old_limit_{};
};

// Expects that `write` fails on a disk that is full after `bytes`, that old files of these names
// survive, and that it leaves no others in the folder, which must be empty before.
template <typename Write>
void ExpectAFullDiskKeeps(const TemporaryDirectory& folder, const std::vector<std::string>& names,
                          rlim_t bytes, const Write& write) {
  for (const std::string& name : names) WriteText(folder / name, "old");
  {
    const FileSizeLimit full(bytes);
    write();
  }
  for (const std::string& name : names) EXPECT_EQ(ReadText(folder / name), "old") << name;
  EXPECT_EQ(folder.FileCount(), names.size()) << "a temporary stayed behind";
}

}  // namespace highwall::testing
