// The files of bags: every container gives the messages that were written to it.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/bag_imu.h>

#include "input/bag_file.h"
#include "support/bag_files.h"
#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::bag_files_test {
namespace {

namespace fs = std::filesystem;
using testing::Compressed;
using testing::ExpectError;
using testing::LittleEndian;
using testing::McapOf;
using testing::RosbagOf;
using testing::TemporaryDirectory;
using testing::WriteSqliteBag;
using testing::WriteText;
using testing::WrittenMessage;

// Messages of several sizes up to one that fills a chunk; every third is of /b. Content is half
// random, so that it can be compressed.
std::vector<WrittenMessage> SomeMessages() {
  std::vector<WrittenMessage> messages;
  std::uint32_t random = 1;
  for (int i = 0; i < 60; ++i) {
    std::string bytes;
    for (int k = 0; k < 1 + 450 * i; ++k) {
      random = random * 1664525 + 1013904223;
      bytes += static_cast<char>(k % 2 == 0 ? random >> 24 : 7);
    }
    if (i == 30) bytes.resize(400'000, 'x');
    messages.push_back(
        {i % 3 == 0 ? "/b" : "/a", "std_msgs/String", 1'000'000'000 + i * 1000, bytes});
  }
  return messages;
}

void ExpectSame(const fs::path& path, const std::vector<WrittenMessage>& written) {
  const auto bag = OpenBag(path);
  ASSERT_EQ(bag->messages().size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    const BagMessage& message = bag->messages()[i];
    EXPECT_EQ(bag->topics()[message.topic].name, written[i].topic);
    EXPECT_EQ(bag->topics()[message.topic].type, "std_msgs/String");
    EXPECT_EQ(message.recorded, written[i].recorded);
    const std::vector<std::uint8_t> bytes = bag->Read(message);
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), written[i].bytes) << i;
    for (std::size_t k = 0; k < BagMessage::kHead; ++k) {
      EXPECT_EQ(message.head[k], k < bytes.size() ? bytes[k] : 0);
    }
  }
  EXPECT_EQ(bag->topics().size(), 2U);
  EXPECT_EQ(bag->topics()[0].messages, 20U);
}

TEST(Rosbag, GivesTheMessagesInEveryCompression) {
  const TemporaryDirectory folder;
  for (const char* compression : {"none", "bz2", "lz4"}) {
    WriteText(folder / "a.bag", RosbagOf(SomeMessages(), compression));
    ExpectSame(folder / "a.bag", SomeMessages());
    EXPECT_EQ(OpenBag(folder / "a.bag")->topics()[0].encoding, MessageEncoding::kRos1);
  }
}

TEST(McapBag, GivesTheMessagesInEveryCompressionAndWithoutChunks) {
  const TemporaryDirectory folder;
  for (const char* compression : {"none", "lz4", "zstd", "unchunked"}) {
    for (const bool is_ros1 : {false, true}) {
      WriteText(folder / "a.mcap", McapOf(SomeMessages(), compression, is_ros1));
      ExpectSame(folder / "a.mcap", SomeMessages());
      EXPECT_EQ(OpenBag(folder / "a.mcap")->topics()[0].encoding,
                is_ros1 ? MessageEncoding::kRos1 : MessageEncoding::kCdr);
    }
  }
}

TEST(SqliteBag, GivesTheMessagesAlsoIfTheyAreCompressedOneByOne) {
  const TemporaryDirectory folder;
  for (const bool compressed : {false, true}) {
    const fs::path path = folder / (compressed ? "b.db3" : "a.db3");
    WriteSqliteBag(path, SomeMessages(), compressed);
    ExpectSame(path, SomeMessages());
  }
}

TEST(McapBag, GivesTheMessagesAlsoIfTheyAreCompressedOneByOne) {
  const TemporaryDirectory folder;
  std::vector<WrittenMessage> compressed = SomeMessages();
  for (WrittenMessage& message : compressed) message.bytes = Compressed(message.bytes, "zstd");
  for (const char* of_chunks : {"unchunked", "lz4"}) {
    WriteText(folder / "a.mcap", McapOf(compressed, of_chunks));
    ExpectSame(folder / "a.mcap", SomeMessages());
  }
}

TEST(SqliteBag, ATimeThatNoClockGivesBecomesZero) {
  const TemporaryDirectory folder;
  WriteSqliteBag(folder / "a.db3", {{"/a", "t/T", kMaxStamp, "last"},
                                    {"/a", "t/T", kMaxStamp + 1, "later"},
                                    {"/a", "t/T", -1, "before"}});
  const auto bag = OpenBag(folder / "a.db3");
  EXPECT_EQ(bag->messages()[0].recorded, 0);
  EXPECT_EQ(bag->messages()[1].recorded, 0);
  EXPECT_EQ(bag->messages()[2].recorded, kMaxStamp);
}

TEST(OpenBag, AFolderIsTheSequenceOfItsFiles) {
  const TemporaryDirectory folder;
  const std::vector<WrittenMessage> all = SomeMessages();
  const auto part = [&](int from, int to) {
    return std::vector<WrittenMessage>(all.begin() + from, all.begin() + to);
  };
  WriteText(folder / "metadata.yaml", "rosbag2_bagfile_information:\n");
  WriteSqliteBag(folder / "r_10.db3", part(40, 60));
  WriteSqliteBag(folder / "r_2.db3", part(21, 40));
  WriteText(folder / "r_0.mcap", McapOf(part(0, 21)));
  EXPECT_TRUE(IsBag(folder.path()));
  ExpectSame(folder.path(), all);
}

TEST(OpenBag, ACompressedFileThatIsUnpackedInItsFolderIsLeftOut) {
  const TemporaryDirectory folder;
  WriteSqliteBag(folder / "r_0.db3", SomeMessages());
  WriteText(folder / "r_0.db3.zstd", "compressed");
  ExpectSame(folder.path(), SomeMessages());
  WriteText(folder / "r_1.db3.zstd", "compressed");
  ExpectError<IoError>("r_1.db3.zstd: is compressed as a whole", [&] { OpenBag(folder.path()); });
}

TEST(OpenBag, MessagesAreInTheOrderOfTheirRecording) {
  const TemporaryDirectory folder;
  WriteText(folder / "a.bag", RosbagOf({{"/a", "t/T", 3'000, "third"},
                                        {"/a", "t/T", 1'000, "first"},
                                        {"/b", "t/T", 2'000, "second"}}));
  const auto bag = OpenBag(folder / "a.bag");
  EXPECT_EQ(bag->messages()[0].recorded, 1'000);
  EXPECT_EQ(bag->messages()[1].recorded, 2'000);
  EXPECT_EQ(bag->messages()[2].recorded, 3'000);
}

TEST(OpenBag, SeveralThreadsReadTheSameMessages) {
  const TemporaryDirectory folder;
  const std::vector<WrittenMessage> written = SomeMessages();
  WriteText(folder / "a.bag", RosbagOf(written, "lz4"));
  WriteSqliteBag(folder / "a.db3", written);
  for (const char* name : {"a.bag", "a.db3"}) {
    const auto bag = OpenBag(folder / name);
    const auto read = [&](std::size_t stride) {
      for (std::size_t k = 0; k < written.size(); ++k) {
        const std::size_t i = k * stride % written.size();
        const std::vector<std::uint8_t> bytes = bag->Read(bag->messages()[i]);
        EXPECT_EQ(std::string(bytes.begin(), bytes.end()), written[i].bytes);
      }
    };
    std::vector<std::jthread> threads;
    for (const std::size_t stride : {1U, 7U, 11U}) threads.emplace_back(read, stride);
  }
}

// Every length of the file but the whole one is refused, with the name of the file.
void ExpectRefusedWhereverItEnds(const fs::path& path, const std::string& content) {
  for (std::size_t size = 1; size < content.size(); size += 1 + content.size() / 97) {
    WriteText(path, content.substr(0, size));
    ExpectError<IoError>(path.string() + ": ", [&] { OpenBag(path); });
  }
}

TEST(OpenBag, ATruncatedFileIsRefused) {
  const TemporaryDirectory folder;
  const std::vector<WrittenMessage> all = SomeMessages();
  const std::vector<WrittenMessage> some(all.begin(), all.begin() + 20);
  // Of a bag of ROS 1 without its index, which is at the end.
  const std::string bag = RosbagOf(some, "lz4");
  ExpectRefusedWhereverItEnds(folder / "a.bag", bag.substr(0, bag.size() - 250));
  ExpectRefusedWhereverItEnds(folder / "a.mcap", McapOf(some, "zstd"));
  ExpectError<IoError>("repair it with mcap recover", [&] { OpenBag(folder / "a.mcap"); });
  WriteText(folder / "b.bag", bag.substr(0, bag.size() / 2));
  ExpectError<IoError>("b.bag: is truncated: a record at byte ",
                       [&] { OpenBag(folder / "b.bag"); });
}

TEST(OpenBag, SaysWhatIsWrongWithAFile) {
  const TemporaryDirectory folder;
  const auto expect = [&](const std::string& name, const std::string& content,
                          const std::string& message) {
    WriteText(folder / name, content);
    ExpectError<IoError>(name + ": " + message, [&] { OpenBag(folder / name); });
  };
  expect("a.bag", RosbagOf(SomeMessages(), "none", false),
         "has no index, because its recording was not ended: repair it with rosbag reindex");
  expect("a.bag", "", "is empty");
  expect("a.mcap", "", "is empty");
  expect("a.db3", "", "is empty");
  expect("a.bag", "text", "is not a bag of ROS 1");
  expect("a.bag", "#ROSRECORD V1.1\n", "is a bag of an old format: convert it with rosbag fix");
  expect("a.mcap", "text text text text text", "is not an MCAP file");
  expect("a.db3", "text text text", "is no bag of ROS 2, or is damaged: ");
  expect("a.db3.zstd", "text", "is compressed as a whole: unpack it with zstd -d");
  std::string damaged = RosbagOf(SomeMessages(), "bz2");  // which has a checksum
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x5A);
  expect("a.bag", damaged, "the chunk at byte ");
  // LZ4 as written here has no checksum of its own.
  std::string changed = McapOf(SomeMessages(), "lz4");
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 0x5A);
  expect("a.mcap", changed, "the chunk at byte ");
  ExpectError<IoError>("nowhere.bag: cannot be read: ", [&] { OpenBag(folder / "nowhere.bag"); });
}

TEST(OpenBag, AStatedSizeIsNotBelieved) {
  const TemporaryDirectory folder;
  std::string bag = RosbagOf({{"/a", "t/T", 1, std::string(100, 'x')}}, "lz4");
  const std::size_t size = bag.find("size=") + 5;
  bag.replace(size, 4, "\xFF\xFF\xFF\x7F");
  WriteText(folder / "a.bag", bag);
  ExpectError<IoError>("a.bag: is damaged: the chunk at byte ", [&] { OpenBag(folder / "a.bag"); });
  bag.replace(size, 4, std::string("\x10\0\0\0", 4));
  WriteText(folder / "a.bag", bag);
  ExpectError<IoError>("cannot be decompressed", [&] { OpenBag(folder / "a.bag"); });
}

// Files with holes, which take no room.
TEST(OpenBag, ALengthThatTheFileHasIsNotBelievedEither) {
  const TemporaryDirectory folder;
  constexpr std::uint64_t kRecord = (std::uint64_t{64} << 20) + 1, kMessage = (1U << 28) + 1;
  const auto expect = [&](const std::string& name, const std::string& begin,
                          const std::string& end) {
    WriteText(folder / name, begin);
    fs::resize_file(folder / name, begin.size() + kRecord);
    std::ofstream(folder / name, std::ios::binary | std::ios::app) << end;
    ExpectError<IoError>(name + ": is damaged: a record at byte " + std::to_string(begin.size()) +
                             " has 67108865 bytes",
                         [&] { OpenBag(folder / name); });
  };
  const std::string mcap = McapOf({{"/a", "t/T", 1, std::string(10, 'x')}}, "unchunked");
  const std::string magic = mcap.substr(0, 8);
  expect("a.bag", "#ROSBAG V2.0\n" + LittleEndian(static_cast<std::uint32_t>(kRecord)), "");
  for (const char op : {'\3', '\4'}) expect("a.mcap", magic + op + LittleEndian(kRecord), magic);

  // A message of 10 bytes, then the records of the end and the magic.
  constexpr std::size_t kHeader = 22, kContent = 10, kEnd = 9 + 4 + 9 + 20 + 8;
  std::string begin = mcap.substr(0, mcap.size() - kEnd);
  begin.replace(begin.size() - kContent - kHeader - 8, 8, LittleEndian(kHeader + kMessage));
  WriteText(folder / "b.mcap", begin);
  fs::resize_file(folder / "b.mcap", begin.size() - kContent + kMessage);
  std::ofstream(folder / "b.mcap", std::ios::binary | std::ios::app)
      << mcap.substr(mcap.size() - kEnd);
  const auto bag = OpenBag(folder / "b.mcap");
  ASSERT_EQ(bag->messages().size(), 1U);
  ExpectError<IoError>("b.mcap: the message of /a recorded at 0.000000001 s has 268435457 bytes",
                       [&] { bag->Read(bag->messages()[0]); });
}

TEST(IsBag, GoesByTheName) {
  const TemporaryDirectory folder;
  for (const char* name : {"a.bag", "a.db3", "a.mcap", "a.mcap.zstd", "a.txt"}) {
    WriteText(folder / name, "");
    EXPECT_EQ(IsBag(folder / name), std::string(name) != "a.txt");
  }
  fs::create_directory(folder / "empty");
  EXPECT_FALSE(IsBag(folder / "empty"));
  EXPECT_FALSE(IsBag(folder / "nowhere.bag"));
}

}  // namespace
}  // namespace highwall::bag_files_test
