#include "input/bag_file.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/input/bag_imu.h>

#include "input/decompression.h"
#include "input/mcap_bag.h"
#include "input/rosbag.h"
#include "input/sqlite_bag.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;

bool IsRos2File(const fs::path& path) {
  return path.extension() == ".db3" || path.extension() == ".mcap";
}

// Compressed as a whole by rosbag2.
bool IsCompressedFile(const fs::path& path) {
  return path.extension() == ".zstd" && IsRos2File(path.stem());
}

// Returns the files of a folder of ROS 2, in the order of their names.
std::vector<fs::path> BagFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (IsRos2File(at->path()) || IsCompressedFile(at->path())) files.push_back(at->path());
  }
  std::erase_if(files, [](const fs::path& path) {  // zstd -d leaves the compressed file there
    std::error_code unknown;
    return IsCompressedFile(path) && fs::exists(path.parent_path() / path.stem(), unknown);
  });
  std::ranges::sort(files);
  return files;
}

std::unique_ptr<BagFile> OpenBagFile(const fs::path& path) {
  if (IsCompressedFile(path)) {
    throw IoError(path,
                  "is compressed as a whole: unpack it with zstd -d, or record with "
                  "--compression-mode message");
  }
  if (path.extension() == ".bag") return std::make_unique<Rosbag>(path);
  if (path.extension() == ".mcap") return std::make_unique<McapBag>(path);
  return std::make_unique<SqliteBag>(path);
}

// The files of one recording, as a bag of ROS 2 is split.
class JoinedBag final : public BagFile {
 public:
  JoinedBag(const fs::path& folder, const std::vector<fs::path>& files) : BagFile(folder) {
    for (const fs::path& path : files) {
      const BagFile& file = *files_.emplace_back(OpenBagFile(path));
      std::vector<std::uint32_t> topics;
      for (const BagTopic& topic : file.topics()) {
        topics.push_back(AddTopic(topic.name, topic.type, topic.encoding));
      }
      for (std::size_t i = 0; i < file.messages().size(); ++i) {
        BagMessage message = file.messages()[i];
        message.topic = topics[message.topic];
        message.part = static_cast<std::uint32_t>(files_.size() - 1);
        message.offset = i;
        AddMessage(message);
      }
    }
    Sort();
  }

  std::vector<std::uint8_t> Read(const BagMessage& message) const override {
    const BagFile& file = *files_.at(message.part);
    return file.Read(file.messages().at(static_cast<std::size_t>(message.offset)));
  }

 private:
  std::vector<std::unique_ptr<BagFile>> files_;
};

}  // namespace

std::uint32_t BagFile::AddTopic(const std::string& name, std::string type,
                                MessageEncoding encoding) {
  if (const std::size_t middle = type.find("/msg/"); middle != std::string::npos) {
    type.erase(middle, 4);
  }
  const auto known = std::ranges::find_if(topics_, [&](const BagTopic& topic) {
    return topic.name == name && topic.type == type && topic.encoding == encoding;
  });
  const auto index = static_cast<std::uint32_t>(known - topics_.begin());
  if (known == topics_.end()) topics_.push_back({name, std::move(type), encoding, 0});
  return index;
}

const BagMessage* BagFile::FirstOf(std::uint32_t topic) const {
  const auto found = std::ranges::find(messages_, topic, &BagMessage::topic);
  return found == messages_.end() ? nullptr : &*found;
}

std::string BagFile::NameOf(const BagMessage& message) const {
  return "the message of " + topics_.at(message.topic).name + " recorded at " +
         FormatStamp(message.recorded) + " s";
}

std::vector<std::uint8_t> BagFile::ContentOf(const BagMessage& message,
                                             std::vector<std::uint8_t> stored) const {
  if (topics_.at(message.topic).encoding != MessageEncoding::kCdr || !IsZstd(stored)) return stored;
  return DecompressZstd(path_, NameOf(message), stored, kLargestMessage);
}

Stamp BagFile::RecordedStamp(std::uint64_t time) {
  return time <= static_cast<std::uint64_t>(kMaxStamp) ? static_cast<Stamp>(time) : 0;
}

void BagFile::AddMessage(const BagMessage& message) {
  ++topics_.at(message.topic).messages;
  messages_.push_back(message);
}

void BagFile::Sort() {
  std::ranges::stable_sort(messages_, {}, &BagMessage::recorded);
  messages_.shrink_to_fit();
}

bool IsBag(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return !BagFilesIn(path).empty();
  return fs::is_regular_file(path, error) &&
         (path.extension() == ".bag" || IsRos2File(path) || IsCompressedFile(path));
}

std::unique_ptr<BagFile> OpenBag(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return OpenBagFile(path);
  const std::vector<fs::path> files = BagFilesIn(path);
  if (files.empty()) throw IoError(path, "holds no bag: no .db3 and no .mcap");
  return std::make_unique<JoinedBag>(path, files);
}

}  // namespace highwall
