#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "input/bag_file.h"

struct sqlite3;
struct sqlite3_blob;

namespace highwall {

// A file of ROS 2 in a database of SQLite. Messages that are compressed one by one are read as
// well.
class SqliteBag final : public BagFile {
 public:
  // Throws IoError if it is no such database or is damaged.
  explicit SqliteBag(const std::filesystem::path& path);

  std::vector<std::uint8_t> Read(const BagMessage& message) const override;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };

  void ReadTopics(std::vector<std::pair<std::int64_t, std::uint32_t>>* topics);
  void ReadMessages(const std::vector<std::pair<std::int64_t, std::uint32_t>>& topics);
  // Returns at most the first `most` bytes of the message in this row.
  std::vector<std::uint8_t> ReadRow(std::int64_t row, std::uint64_t most) const;

  mutable std::mutex mutex_;
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace highwall
