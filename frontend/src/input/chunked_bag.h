#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "input/bag_file.h"
#include "input/byte_reader.h"
#include "input/decompression.h"
#include "input/random_access_file.h"

namespace highwall {

// A bag whose messages are in the file itself or in chunks of it, which may be compressed: what the
// formats of ROS 1 and MCAP share. The last chunks that were read are kept.
class ChunkedBag : public BagFile {
 public:
  std::vector<std::uint8_t> Read(const BagMessage& message) const override;

 protected:
  // Throws IoError if the file cannot be opened.
  explicit ChunkedBag(const std::filesystem::path& path) : BagFile(path), file_(path) {}

  // Bytes in which records follow each other: the file, or the content of a chunk.
  class Records {
   public:
    // part: BagMessage::part of messages in them.
    Records(const ChunkedBag& bag, std::uint32_t part, std::uint64_t begin, std::uint64_t end)
        : bag_(bag), part_(part), position_(begin), end_(end) {}

    std::uint32_t part() const { return part_; }
    std::uint64_t position() const { return position_; }
    bool IsAtEnd() const { return position_ == end_; }
    std::uint64_t rest() const { return end_ - position_; }
    // Returns the next bytes, after which it stands. Throws IoError if they end before or are more
    // than any record but a message has.
    std::vector<std::uint8_t> Take(std::uint64_t size);
    // The same bytes, but at most `most` of them.
    std::vector<std::uint8_t> TakeHead(std::uint64_t size, std::uint64_t most);
    void Skip(std::uint64_t size);

   private:
    void Require(std::uint64_t size) const;

    const ChunkedBag& bag_;
    std::uint32_t part_;
    std::uint64_t position_, end_;
  };

  const RandomAccessFile& file() const { return file_; }
  Records RecordsOfFile(std::uint64_t begin) const { return {*this, 0, begin, file_.size()}; }
  // Returns those of a chunk whose stored bytes lie there in the file. size, crc32: of its content;
  // the checksum is 0 where there is none, and that of a chunk that is not compressed is not
  // tested.
  Records AddChunk(std::uint64_t offset, std::uint64_t stored, Compression compression,
                   std::uint64_t size, std::uint32_t crc32 = 0);
  // Adds a message that begins here; `records` then stands behind it.
  void AddMessageOf(Records* records, std::uint32_t topic, Stamp recorded, std::uint64_t size);
  // What to do about a truncated file.
  virtual std::string_view remedy() const = 0;

 private:
  using Content = std::shared_ptr<const std::vector<std::uint8_t>>;

  struct Chunk {
    std::uint64_t offset = 0, stored = 0;  // [byte] in the file
    Compression compression = Compression::kNone;
    std::uint64_t size = 0;  // [byte] of the content
    std::uint32_t crc32 = 0;
  };

  std::vector<std::uint8_t> ReadPart(std::uint32_t part, std::uint64_t offset,
                                     std::uint64_t size) const;
  Content ContentOfChunk(std::uint32_t chunk) const;

  RandomAccessFile file_;
  std::vector<Chunk> chunks_;  // of part 1 and so on; 0: the file
  mutable std::mutex mutex_;
  mutable std::list<std::pair<std::uint32_t, Content>> kept_;  // chunks, the latest first
};

}  // namespace highwall
