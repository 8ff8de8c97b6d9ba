#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>

#include "input/chunked_bag.h"

namespace highwall {

// A bag of ROS 1. Read here rather than by librosbag-storage, which several threads cannot share
// and which needs ROS. Source: ROS wiki, "Bags/Format/2.0", https://wiki.ros.org/Bags/Format/2.0
class Rosbag final : public ChunkedBag {
 public:
  // Throws IoError if it is no bag of format 2.0, has no index, is truncated or damaged.
  explicit Rosbag(const std::filesystem::path& path);

 private:
  struct Header;

  Header TakeHeader(Records* records) const;
  void ReadBagHeader(Records* records) const;
  void ReadRecords(Records records, bool is_chunk);
  void ReadChunk(const Header& header, Records* records);
  void ReadConnection(const Header& header, Records* records);
  void ReadMessage(const Header& header, Records* records);
  std::string_view remedy() const override { return "repair it with rosbag reindex"; }

  std::map<std::uint32_t, std::uint32_t> topics_;  // of connections
};

}  // namespace highwall
