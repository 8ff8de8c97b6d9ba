#include <highwall/core/atomic_file.h>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "../file_size_limit.h"
#include "../temporary_directory.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;

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
    file.stream().setstate(std::ios::badbit);  // as a full disk leaves it
    EXPECT_THROW(file.Commit(), IoError);
  }
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

TEST_F(AtomicFileTest, AWriteThatTheSystemRefusesIsFoundAtCommit) {
  std::ofstream(folder_ / "a.txt") << "old";
  {
    const testing::FileSizeLimit limit(4096);
    AtomicFile file(folder_ / "a.txt");
    file.stream() << std::string(1 << 20, 'x');
    EXPECT_THROW(file.Commit(), IoError);
  }
  EXPECT_EQ(testing::ReadText(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.FileCount(), 1u);
}

TEST_F(AtomicFileTest, ALinkStaysAndWhatItLeadsToIsReplaced) {
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
}  // namespace highwall
