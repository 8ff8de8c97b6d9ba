#include "input/mcap_bag.h"

#include <algorithm>
#include <array>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

#include "input/byte_reader.h"

namespace highwall {
namespace {

constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

MessageEncoding McapEncoding(const std::string& name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  return name == "ros1" ? MessageEncoding::kRos1 : MessageEncoding::kOther;
}

}  // namespace

enum class McapBag::Op : std::uint8_t {
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0F,
};

McapBag::McapBag(const std::filesystem::path& path) : ChunkedBag(path) {
  if (file().size() == 0) throw IoError(path, "is empty");
  const auto is_magic_at = [&](std::uint64_t offset) {
    return file().Holds(offset, kMcapMagic.size()) &&
           std::ranges::equal(file().Read(offset, kMcapMagic.size()), kMcapMagic);
  };
  if (!is_magic_at(0)) throw IoError(path, "is not an MCAP file: it does not begin as one");
  if (file().size() < 2 * kMcapMagic.size() || !is_magic_at(file().size() - kMcapMagic.size())) {
    throw IoError(path,
                  "is truncated, because its recording was not ended: " + std::string(remedy()));
  }
  Records records = RecordsOfFile(kMcapMagic.size());
  while (ReadRecord(&records, false)) {
  }
  Sort();
}

// Returns false after the last record of the data.
bool McapBag::ReadRecord(Records* records, bool is_chunk) {
  if (is_chunk && records->IsAtEnd()) return false;
  constexpr std::size_t kHeader = 9;
  const std::vector<std::uint8_t> bytes = records->Take(kHeader);
  ByteReader header(path(), "the header of a record", bytes);
  const Op op{header.Number<std::uint8_t>()};
  const auto size = header.Number<std::uint64_t>();
  switch (op) {
    case Op::kSchema:
      ReadSchema(records, size);
      break;
    case Op::kChannel:
      ReadChannel(records, size);
      break;
    case Op::kMessage:
      ReadMessage(records, size);
      break;
    case Op::kChunk:
      if (is_chunk) throw IoError(path(), "is damaged: a chunk contains another one");
      ReadChunk(records, size);
      break;
    case Op::kDataEnd:
      return false;
    default:
      records->Skip(size);
  }
  return true;
}

void McapBag::ReadSchema(Records* records, std::uint64_t size) {
  const std::vector<std::uint8_t> bytes = records->Take(size);
  ByteReader reader(path(), "a schema", bytes);
  const auto id = reader.Number<std::uint16_t>();
  types_[id] = reader.Text();
}

void McapBag::ReadChannel(Records* records, std::uint64_t size) {
  const std::vector<std::uint8_t> bytes = records->Take(size);
  ByteReader reader(path(), "a channel", bytes);
  const auto id = reader.Number<std::uint16_t>(), schema = reader.Number<std::uint16_t>();
  const std::string topic = reader.Text(), encoding = reader.Text();
  const auto type = types_.find(schema);
  channels_[id] = AddTopic(topic, type == types_.end() ? "" : type->second, McapEncoding(encoding));
}

void McapBag::ReadMessage(Records* records, std::uint64_t size) {
  constexpr std::uint64_t kHeader = 22;  // channel, sequence, and two times
  if (size < kHeader) throw IoError(path(), "is damaged: a message is shorter than its header");
  const std::vector<std::uint8_t> bytes = records->Take(kHeader);
  ByteReader reader(path(), "the header of a message", bytes);
  const auto channel = channels_.find(reader.Number<std::uint16_t>());
  if (channel == channels_.end()) throw IoError(path(), "is damaged: a message has no channel");
  reader.Skip(sizeof(std::uint32_t));
  const Stamp recorded = RecordedStamp(reader.Number<std::uint64_t>());
  AddMessageOf(records, channel->second, recorded, size - kHeader);
}

void McapBag::ReadChunk(Records* records, std::uint64_t size) {
  constexpr std::uint64_t kTimes = 16, kRest = 8 + 4;  // size and checksum of the content
  const std::uint64_t end = records->position() + size;
  if (size > records->rest()) records->Skip(size);  // which refuses it
  const std::vector<std::uint8_t> bytes =
      records->TakeHead(size, std::min<std::uint64_t>(size, kTimes + kRest + 4 + 64));
  ByteReader reader(path(), "the header of a chunk", bytes);
  reader.Skip(kTimes);
  const auto content = reader.Number<std::uint64_t>();
  const auto crc32 = reader.Number<std::uint32_t>();
  const std::string name = reader.Text();
  const auto stored = reader.Number<std::uint64_t>();
  const std::uint64_t begin = end - size + reader.position();
  if (stored > end - begin) throw IoError(path(), "is damaged: a chunk is longer than its record");
  const std::optional<Compression> compression = CompressionNamed(name);
  if (!compression || *compression == Compression::kBzip2) {
    throw IoError(path(), "has chunks in the unknown compression '" + name + "'");
  }
  Records inside = AddChunk(begin, stored, *compression, content, crc32);
  while (ReadRecord(&inside, true)) {
  }
}

}  // namespace highwall
