#include <highwall/core/atomic_file.h>

#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/file_lock.h>

#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace highwall::atomic_file_test {
namespace {

namespace fs = std::filesystem;

constexpr auto kLong = std::chrono::hours(25);

// Returns whether `folder` was cleaned up by a process that cannot see any other process of this
// machine, as is the case in a container.
bool CleanInAnotherPidNamespace(const fs::path& folder) {
  constexpr int kNotAllowed = 77;
  const pid_t child = ::fork();
  if (child == 0) {
    if (::unshare(CLONE_NEWPID) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWPID) != 0) {
      ::_exit(kNotAllowed);
    }
    const pid_t inside = ::fork();  // the first process of the namespace
    if (inside == 0) {
      RemoveTemporariesOfDeadProcesses(folder);
      ::_exit(::getpid() == 1 ? 0 : 1);
    }
    int status = 0;
    const bool cleaned =
        ::waitpid(inside, &status, 0) == inside && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    ::_exit(cleaned ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  const int exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  EXPECT_TRUE(exit_code == 0 || exit_code == kNotAllowed) << exit_code;
  return exit_code == 0;
}

class AtomicFileTest : public ::testing::Test {
 protected:
  testing::TemporaryDirectory folder_;
};

TEST_F(AtomicFileTest, AppearsWholeOnCommit) {
  AtomicFile file(folder_ / "a.txt");
  file.stream() << "one\n";
  EXPECT_FALSE(fs::exists(folder_ / "a.txt"));
  file.Commit();
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "one\n");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

TEST_F(AtomicFileTest, WithoutCommitTheOldFileStaysAndNothingIsLeftBehind) {
  std::ofstream(folder_ / "a.txt") << "old";
  {
    AtomicFile file(folder_ / "a.txt");
    file.stream() << "new";
  }
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

TEST_F(AtomicFileTest, CommitReplacesTheOldFile) {
  std::ofstream(folder_ / "a.txt") << "old and longer";
  AtomicFile file(folder_ / "a.txt");
  file.stream() << "new";
  file.Commit();
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "new");
}

TEST_F(AtomicFileTest, TemporaryKeepsFolderAndExtension) {
  const AtomicFile file(folder_ / "cloud.ply");
  EXPECT_EQ(file.temporary().parent_path(), folder_.path());
  EXPECT_EQ(file.temporary().extension(), ".ply");
}

TEST_F(AtomicFileTest, AWriterMayUseTheTemporaryByName) {
  AtomicFile file(folder_ / "a.txt");
  std::ofstream(file.temporary()) << "by name";
  file.Commit();
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "by name");
}

TEST_F(AtomicFileTest, TwoWritersOfOnePathDoNotMixTheirBytes) {
  AtomicFile first(folder_ / "a.txt"), second(folder_ / "a.txt");
  first.stream() << "first";
  second.stream() << "the second";
  first.Commit();
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "first");
  second.Commit();
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "the second");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

TEST_F(AtomicFileTest, AMissingFolderThrowsWithThePath) {
  const fs::path path = folder_ / "missing" / "a.txt";
  try {
    AtomicFile file(path);
    FAIL() << "no exception";
  } catch (const IoError& e) {
    EXPECT_NE(std::string(e.what()).find(path.string()), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("No such file"), std::string::npos) << e.what();
  }
}

TEST_F(AtomicFileTest, AFailedWriteThrowsAtCommitAndKeepsTheOldFile) {
  std::ofstream(folder_ / "a.txt") << "old";
  {
    AtomicFile file(folder_ / "a.txt");
    file.stream() << "partial";
    file.stream().setstate(std::ios::badbit);  // the state after the disk is full
    EXPECT_THROW(file.Commit(), IoError);
  }
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

// The data are written in one piece, in pieces that fit the buffer, character by character, or only
// at the end.
TEST_F(AtomicFileTest, AWriteThatTheSystemRefusesIsFoundAtCommitWithItsReasonAndTheFinalName) {
  const auto at_once = [](std::ostream& out) { out << std::string(1 << 20, 'x'); };
  const auto in_pieces = [](std::ostream& out) {
    for (int i = 0; i < 10000; ++i) out << "0.123456789 " << i << '\n';
  };
  const auto by_character = [](std::ostream& out) {
    for (int i = 0; i < 10000; ++i) out.put('x');
  };
  const auto flushed = [](std::ostream& out) { out << std::string(5000, 'x') << std::flush; };
  const auto in_the_end = [](std::ostream& out) { out << std::string(5000, 'x'); };
  const std::vector<std::function<void(std::ostream&)>> writers = {at_once, in_pieces, by_character,
                                                                   flushed, in_the_end};
  const std::string path = folder_ / "a.txt";
  for (std::size_t i = 0; i < writers.size(); ++i) {
    SCOPED_TRACE(i);
    std::ofstream(path) << "old";
    std::string message;
    {
      const testing::FileSizeLimit limit(4096);
      AtomicFile file(path);
      writers[i](file.stream());
      try {
        file.Commit();
      } catch (const IoError& error) {
        message = error.what();
      }
    }
    EXPECT_EQ(message, path + ": could not be written whole: File too large");
    EXPECT_EQ(testing::ReadText(path), "old");
    EXPECT_EQ(folder_.FileCount(), 1u);
  }
}

TEST_F(AtomicFileTest, RemovesLeftoversOfAKilledProcessAndNothingElse) {
  const fs::path map = folder_ / "room.hwmap", plain = folder_ / "noextension";
  const pid_t child = ::fork();
  if (child == 0) {
    AtomicFile first(map), second(plain);
    first.stream() << "half" << std::flush;
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(folder_.FileCount(), 2u);

  AtomicFile alive(map);
  for (const char* others :
       {".hidden", ".vimrc.swp", "a.hw01234567-0123456789abcdef.txt", ".a.hw01234567.txt",
        ".a.hw0123456g-0123456789abcdef.txt", ".a.hw01234567-0123456789abcde.txt",
        ".a.hwm1234567-0123456789abcdef"}) {
    std::ofstream(folder_ / others) << "other";
    fs::last_write_time(folder_ / others, fs::file_time_type::clock::now() - kLong);
  }
  RemoveTemporariesOfDeadProcesses(folder_.path());
  EXPECT_EQ(folder_.FileCount(), 8u);
  alive.stream() << "new";
  alive.Commit();
  EXPECT_EQ(testing::ReadText(map), "new");
  EXPECT_NO_THROW(RemoveTemporariesOfDeadProcesses(folder_ / "missing"));
}

TEST_F(AtomicFileTest, DoesNotRemoveAFileWrittenInAnotherPidNamespace) {
  AtomicFile file(folder_ / "map.hwmap");
  file.stream() << "whole";
  if (!CleanInAnotherPidNamespace(folder_.path())) GTEST_SKIP() << "no PID namespace can be made";
  ASSERT_TRUE(fs::exists(file.temporary()));
  EXPECT_NO_THROW(file.Commit());
  EXPECT_EQ(testing::ReadText(folder_ / "map.hwmap"), "whole");
}

// The file system may keep locks local to each machine, so only the age of a file shows that its
// writer is dead.
TEST_F(AtomicFileTest, RemovesLeftoversOfAnotherMachineAfterADay) {
  const fs::path fresh = folder_ / ".a.hw01234567-0123456789abcdef.txt";
  const fs::path old = folder_ / ".b.hw01234567-0123456789abcdef.txt";
  const fs::path locked = folder_ / ".c.hw01234567-0123456789abcdef.txt";
  for (const fs::path& file : {fresh, old, locked}) std::ofstream(file) << "half";
  for (const fs::path& file : {old, locked}) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - kLong);
  }
  const FileLock lock(locked, FileLock::Open::kExisting);
  RemoveTemporariesOfDeadProcesses(folder_.path());
  EXPECT_TRUE(fs::exists(fresh));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(locked));
}

TEST_F(AtomicFileTest, KeepsALinkAndReplacesItsTarget) {
  fs::create_directories(folder_ / "elsewhere");
  const fs::path target = folder_ / "elsewhere" / "kept.txt", link = folder_ / "link.txt";
  std::ofstream(target) << "old";
  fs::create_symlink(target, link);
  AtomicFile file(link);
  file.stream() << "new";
  file.Commit();
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(testing::ReadText(target), "new");
}

TEST_F(AtomicFileTest, APipeIsRefusedAndStays) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  try {
    AtomicFile file(pipe);
    FAIL() << "must throw";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("pipe"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(AtomicFileTest, APathThatIsAFolderThrowsAtCommit) {
  fs::create_directories(folder_ / "taken" / "inside");
  {
    AtomicFile file(folder_ / "taken");
    file.stream() << "x";
    EXPECT_THROW(file.Commit(), IoError);
  }
  EXPECT_TRUE(fs::is_directory(folder_ / "taken" / "inside"));
  EXPECT_EQ(folder_.FileCount(), 1u);
}

}  // namespace
}  // namespace highwall::atomic_file_test
