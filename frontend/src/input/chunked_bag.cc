#include "input/chunked_bag.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include <libdeflate.h>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 28;    // [byte]
constexpr std::uint64_t kLargestRecord = std::uint64_t{64} << 20;  // [byte] but for messages
constexpr std::uint64_t kMostKept = std::uint64_t{64} << 20;       // [byte] of chunks in memory

}  // namespace

std::vector<std::uint8_t> ChunkedBag::Records::Take(std::uint64_t size) {
  Require(size);
  if (size > kLargestRecord) {
    throw IoError(bag_.path(), "is damaged: a record at byte " + std::to_string(position_) +
                                   " has " + std::to_string(size) + " bytes");
  }
  return TakeHead(size, size);
}

std::vector<std::uint8_t> ChunkedBag::Records::TakeHead(std::uint64_t size, std::uint64_t most) {
  Require(size);
  std::vector<std::uint8_t> bytes = bag_.ReadPart(part_, position_, std::min(size, most));
  position_ += size;
  return bytes;
}

void ChunkedBag::Records::Skip(std::uint64_t size) {
  Require(size);
  position_ += size;
}

void ChunkedBag::Records::Require(std::uint64_t size) const {
  if (size <= rest()) return;
  throw IoError(bag_.path(), (part_ == 0 ? "is truncated: a record at byte "
                                         : "is damaged: a record in a chunk at its byte ") +
                                 std::to_string(position_) + " ends early; " +
                                 std::string(bag_.remedy()));
}

ChunkedBag::Records ChunkedBag::AddChunk(std::uint64_t offset, std::uint64_t stored,
                                         Compression compression, std::uint64_t size,
                                         std::uint32_t crc32) {
  if (compression == Compression::kNone) {  // its messages lie in the file as they are
    return {*this, 0, offset, offset + stored};
  }
  if (const std::uint64_t larger = std::max(size, stored); larger > kLargestChunk) {
    throw IoError(path(), "is damaged: the chunk at byte " + std::to_string(offset) + " has " +
                              std::to_string(larger) + " bytes");
  }
  chunks_.push_back({offset, stored, compression, size, crc32});
  return {*this, static_cast<std::uint32_t>(chunks_.size()), 0, size};
}

void ChunkedBag::AddMessageOf(Records* records, std::uint32_t topic, Stamp recorded,
                              std::uint64_t size) {
  BagMessage message{.recorded = recorded,
                     .topic = topic,
                     .part = records->part(),
                     .offset = records->position(),
                     .size = size};
  std::vector<std::uint8_t> head = records->TakeHead(size, BagMessage::kHead);
  if (IsZstd(head)) head = Read(message);
  std::copy_n(head.begin(), std::min(head.size(), BagMessage::kHead), message.head.begin());
  AddMessage(message);
}

std::vector<std::uint8_t> ChunkedBag::Read(const BagMessage& message) const {
  if (message.size > kLargestMessage) {
    throw IoError(path(), NameOf(message) + " has " + std::to_string(message.size) +
                              " bytes, which no sensor gives");
  }
  return ContentOf(message, ReadPart(message.part, message.offset, message.size));
}

std::vector<std::uint8_t> ChunkedBag::ReadPart(std::uint32_t part, std::uint64_t offset,
                                               std::uint64_t size) const {
  if (part == 0) return file_.Read(offset, size);
  const Content content = ContentOfChunk(part);
  if (offset > content->size() || size > content->size() - offset) {
    throw IoError(path(), "is damaged: a chunk ends early");
  }
  const auto begin = content->begin() + static_cast<std::ptrdiff_t>(offset);
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

// Two threads may decompress one chunk at once: neither waits for the other.
ChunkedBag::Content ChunkedBag::ContentOfChunk(std::uint32_t part) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find(kept_, part, &decltype(kept_)::value_type::first);
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return found->second;
    }
  }
  const Chunk& chunk = chunks_.at(part - 1);
  const std::string name = "the chunk at byte " + std::to_string(chunk.offset);
  const auto content = std::make_shared<const std::vector<std::uint8_t>>(Decompress(
      path(), name, chunk.compression, file_.Read(chunk.offset, chunk.stored), chunk.size));
  if (chunk.crc32 != 0 && libdeflate_crc32(0, content->data(), content->size()) != chunk.crc32) {
    throw IoError(path(), name + " is damaged: its checksum is wrong");
  }
  const std::scoped_lock lock(mutex_);
  kept_.emplace_front(part, content);
  std::uint64_t bytes = 0;
  const auto old = std::find_if(std::next(kept_.begin()), kept_.end(),
                                [&, first = content->size()](const auto& entry) mutable {
                                  bytes += std::exchange(first, 0) + entry.second->size();
                                  return bytes > kMostKept;
                                });
  kept_.erase(old, kept_.end());
  return content;
}

}  // namespace highwall
