#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <highwall/core/stamp.h>

namespace highwall {

// How the messages of a topic are written.
enum class MessageEncoding { kRos1, kCdr, kOther };

struct BagTopic {
  std::string name;
  std::string type;  // as in ROS 1, also in a bag of ROS 2: "sensor_msgs/Image"
  MessageEncoding encoding = MessageEncoding::kOther;
  std::size_t messages = 0;
};

// Where a message is.
struct BagMessage {
  // Its first bytes, in which the stamp of a message with a header is; 0 beyond its end.
  static constexpr std::size_t kHead = 12;

  Stamp recorded = 0;       // when it was recorded
  std::uint32_t topic = 0;  // index in BagFile::topics()
  std::uint32_t part = 0;   // of a bag of several files, and of a file with chunks
  std::uint64_t offset = 0;
  std::uint64_t size = 0;  // [byte]
  std::array<std::uint8_t, kHead> head{};
};

// A file of recorded messages. All functions may be called from several threads at once.
class BagFile {
 public:
  virtual ~BagFile() = default;
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  // For messages.
  const std::filesystem::path& path() const { return path_; }
  const std::vector<BagTopic>& topics() const { return topics_; }
  // By ascending stamps of recording.
  const std::vector<BagMessage>& messages() const { return messages_; }

  // The first message of a topic; null if it has none.
  const BagMessage* FirstOf(std::uint32_t topic) const;
  // Names a message for errors: "the message of /imu recorded at 12.345678 s".
  std::string NameOf(const BagMessage& message) const;

  // Returns the content of one of messages(). Throws IoError if it cannot be read or is larger than
  // any message of a sensor.
  virtual std::vector<std::uint8_t> Read(const BagMessage& message) const = 0;

 protected:
  // [byte] of a message, compressed or not: a length that is damaged takes no more memory.
  static constexpr std::uint64_t kLargestMessage = std::uint64_t{1} << 28;

  explicit BagFile(std::filesystem::path path) : path_(std::move(path)) {}
  // Returns the index of the topic, which is added if it is new. type: of ROS 1 or ROS 2.
  std::uint32_t AddTopic(const std::string& name, std::string type, MessageEncoding encoding);
  void AddMessage(const BagMessage& message);
  // Returns the content of a message of this topic: ROS 2 may compress each by itself, and none in
  // CDR begins as zstd does. Throws IoError if it is damaged.
  std::vector<std::uint8_t> ContentOf(const BagMessage& message,
                                      std::vector<std::uint8_t> stored) const;
  // Returns the stamp of a recording; a time [ns] that no clock gives becomes 0.
  static Stamp RecordedStamp(std::uint64_t time);
  // To be called when all messages are added.
  void Sort();

 private:
  std::filesystem::path path_;
  std::vector<BagTopic> topics_;
  std::vector<BagMessage> messages_;
};

// Opens a bag of ROS 1 (format 2.0) or ROS 2 (SQLite or MCAP; of a folder all files). Throws
// IoError if it is none, is damaged or truncated, has no index, or is compressed in another way
// than the formats know.
std::unique_ptr<BagFile> OpenBag(const std::filesystem::path& path);

}  // namespace highwall
