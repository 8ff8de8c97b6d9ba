#include <highwall/core/file_lock.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"

namespace highwall::file_lock_test {
namespace {

using Open = FileLock::Open;
using State = FileLock::State;

TEST(FileLockTest, IsHeldByOneAtATime) {
  const testing::TemporaryDirectory folder;
  const std::filesystem::path path = folder / "lock";
  {
    const FileLock first(path, Open::kAny);
    EXPECT_EQ(first.state(), State::kHeld);
    EXPECT_EQ(FileLock(path, Open::kAny).state(), State::kTaken);
    EXPECT_EQ(FileLock(path, Open::kExisting).state(), State::kTaken);
  }
  EXPECT_EQ(FileLock(path, Open::kExisting).state(), State::kHeld);
}

TEST(FileLockTest, EndsWithItsProcess) {
  const testing::TemporaryDirectory folder;
  const std::filesystem::path path = folder / "lock";
  const pid_t child = ::fork();
  if (child == 0) {
    const FileLock lock(path, Open::kAny);
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(FileLock(path, Open::kExisting).state(), State::kHeld);
}

TEST(FileLockTest, SaysWhyAFileCannotBeOpened) {
  const testing::TemporaryDirectory folder;
  const FileLock missing(folder / "none", Open::kExisting);
  EXPECT_EQ(missing.state(), State::kFailed);
  EXPECT_EQ(missing.error(), ENOENT);
  std::ofstream(folder / "there") << "kept";
  EXPECT_EQ(FileLock(folder / "there", Open::kNew).error(), EEXIST);
  EXPECT_EQ(FileLock(folder / "there", Open::kAny).state(), State::kHeld);
  EXPECT_EQ(testing::ReadText(folder / "there"), "kept");
}

}  // namespace
}  // namespace highwall::file_lock_test
