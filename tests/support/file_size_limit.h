#pragma once

#include <sys/resource.h>

#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"

namespace highwall::testing {

// While it lives no file of this process can grow beyond `bytes`: what a full disk looks like to a
// writer.
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

// Old files of these names outlive `write`, which has to fail on a disk that is full after `bytes`,
// and it leaves no others in the folder, which is empty so far.
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
