#include "input/sqlite_bag.h"

#include "fuzz.h"
#include "support/bag_files.h"

namespace highwall::fuzz {

// With pages that are small, a database has a size that scripts/fuzz does not cut.
const Target kTarget{
    .file_name = "recording.db3",
    .seeds =
        [] {
          const std::vector<testing::WrittenMessage> messages{
              {"/a", "std_msgs/String", 1'000'000'001, std::string(40, 'x')},
              {"/b", "std_msgs/String", 2'000'000'002, "message"}};
          std::vector<std::string> seeds;
          for (const bool compressed : {false, true}) {
            std::filesystem::remove(ScratchFolder() / "written");
            seeds.push_back(Written([&](const std::filesystem::path& path) {
              testing::WriteSqliteBag(path, messages, compressed, 512);
            }));
          }
          return seeds;
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const SqliteBag bag(path);
          for (const BagMessage& message : bag.messages()) bag.Read(message);
        },
};

}  // namespace highwall::fuzz
