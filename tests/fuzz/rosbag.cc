#include "input/rosbag.h"

#include "fuzz.h"
#include "support/bag_files.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "recording.bag",
    .seeds =
        [] {
          const std::vector<testing::WrittenMessage> messages{
              {"/a", "std_msgs/String", 1'000'000'001, std::string(40, 'x')},
              {"/b", "std_msgs/String", 2'000'000'002, "message"}};
          return std::vector<std::string>{testing::RosbagOf(messages),
                                          testing::RosbagOf(messages, "lz4"),
                                          testing::RosbagOf(messages, "bz2")};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const Rosbag bag(path);
          for (const BagMessage& message : bag.messages()) bag.Read(message);
        },
};

}  // namespace highwall::fuzz
