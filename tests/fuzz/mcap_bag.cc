#include "input/mcap_bag.h"

#include "fuzz.h"
#include "support/bag_files.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "recording.mcap",
    .seeds =
        [] {
          const std::vector<testing::WrittenMessage> messages{
              {"/a", "std_msgs/String", 1'000'000'001, std::string(40, 'x')},
              {"/b", "std_msgs/String", 2'000'000'002, "message"}};
          return std::vector<std::string>{
              testing::McapOf(messages), testing::McapOf(messages, "lz4"),
              testing::McapOf(messages, "zstd"), testing::McapOf(messages, "unchunked", true)};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const McapBag bag(path);
          for (const BagMessage& message : bag.messages()) bag.Read(message);
        },
};

}  // namespace highwall::fuzz
