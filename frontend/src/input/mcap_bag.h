#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "input/chunked_bag.h"

namespace highwall {

// A file in the format MCAP, as ROS 2 records it or as made of a bag of ROS 1. Its data section is
// read, so that files without a summary are read as well.
// Source: "MCAP Format Specification", https://mcap.dev/spec
class McapBag final : public ChunkedBag {
 public:
  // Throws IoError if it is no MCAP, is truncated or damaged, or is compressed otherwise than by
  // LZ4 or zstd.
  explicit McapBag(const std::filesystem::path& path);

 private:
  enum class Op : std::uint8_t;

  bool ReadRecord(Records* records, bool is_chunk);
  void ReadSchema(Records* records, std::uint64_t size);
  void ReadChannel(Records* records, std::uint64_t size);
  void ReadMessage(Records* records, std::uint64_t size);
  void ReadChunk(Records* records, std::uint64_t size);
  std::string_view remedy() const override { return "repair it with mcap recover"; }

  std::map<std::uint16_t, std::string> types_;       // of schemas
  std::map<std::uint16_t, std::uint32_t> channels_;  // topics
};

}  // namespace highwall
