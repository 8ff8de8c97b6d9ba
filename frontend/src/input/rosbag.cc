#include "input/rosbag.h"

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/error.h>

#include "input/byte_reader.h"

namespace highwall {
namespace {

constexpr std::string_view kRosbagMagic = "#ROSBAG V2.0\n";

enum class RosbagRecord : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

// The fields of a record or of a connection: a length, a name, "=" and a value, each.
std::map<std::string, std::string> RosbagFields(ByteReader reader) {
  std::map<std::string, std::string> fields;
  while (reader.rest() > 0) {
    const std::string field = reader.Text();
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) reader.Fail("has a field without a name");
    fields[field.substr(0, equals)] = field.substr(equals + 1);
  }
  return fields;
}

ByteSpan BytesOf(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

// The header of a record, and the size of the data behind it.
struct Rosbag::Header {
  const std::filesystem::path& path;
  std::map<std::string, std::string> fields;
  std::uint32_t size = 0;

  const std::string& Text(const std::string& name) const {
    const auto found = fields.find(name);
    if (found == fields.end()) {
      throw IoError(path, "is damaged: a record has no field '" + name + "'");
    }
    return found->second;
  }
  template <class T>
  T Number(const std::string& name) const {
    return ByteReader(path, "the field " + name + " of a record", BytesOf(Text(name)))
        .template Number<T>();
  }
  Stamp Time(const std::string& name) const {
    const auto time = Number<std::uint64_t>(name);  // seconds in the lower half
    return RecordedStamp((time & 0xFFFFFFFF) * 1'000'000'000 + (time >> 32));
  }
};

Rosbag::Rosbag(const std::filesystem::path& path) : ChunkedBag(path) {
  if (file().size() == 0) throw IoError(path, "is empty");
  Records records = RecordsOfFile(0);
  const auto magic = file().Holds(0, kRosbagMagic.size()) ? records.Take(kRosbagMagic.size())
                                                          : std::vector<std::uint8_t>();
  const std::string text(magic.begin(), magic.end());
  if (text != kRosbagMagic) {
    throw IoError(path, text.starts_with("#ROS")
                            ? "is a bag of an old format: convert it with rosbag fix"
                            : "is not a bag of ROS 1: it does not begin with #ROSBAG V2.0");
  }
  ReadBagHeader(&records);
  ReadRecords(records, false);
  Sort();
}

Rosbag::Header Rosbag::TakeHeader(Records* records) const {
  const auto number = [&] {
    const std::vector<std::uint8_t> bytes = records->Take(sizeof(std::uint32_t));
    return ByteReader(path(), "a length", bytes).Number<std::uint32_t>();
  };
  const std::vector<std::uint8_t> bytes = records->Take(number());
  Header header{path(), RosbagFields(ByteReader(path(), "the header of a record", bytes)), 0};
  header.size = number();
  return header;
}

void Rosbag::ReadBagHeader(Records* records) const {
  const Header header = TakeHeader(records);
  if (header.Number<std::uint8_t>("op") != static_cast<std::uint8_t>(RosbagRecord::kBagHeader)) {
    throw IoError(path(), "is damaged: its first record is not that of a bag");
  }
  if (header.Number<std::uint64_t>("index_pos") == 0) {
    throw IoError(
        path(), "has no index, because its recording was not ended: repair it with rosbag reindex");
  }
  records->Skip(header.size);
}

void Rosbag::ReadRecords(Records records, bool is_chunk) {
  while (!records.IsAtEnd()) {
    const Header header = TakeHeader(&records);
    switch (static_cast<RosbagRecord>(header.Number<std::uint8_t>("op"))) {
      case RosbagRecord::kConnection:
        ReadConnection(header, &records);
        break;
      case RosbagRecord::kMessage:
        ReadMessage(header, &records);
        break;
      case RosbagRecord::kChunk:
        if (is_chunk) throw IoError(path(), "is damaged: a chunk contains another one");
        ReadChunk(header, &records);
        break;
      default:  // what an index repeats
        records.Skip(header.size);
    }
  }
}

void Rosbag::ReadChunk(const Header& header, Records* records) {
  const std::string& name = header.Text("compression");
  const std::optional<Compression> compression = CompressionNamed(name);
  if (!compression || *compression == Compression::kZstd) {
    throw IoError(path(), "has chunks in the unknown compression '" + name + "'");
  }
  const std::uint64_t begin = records->position();
  records->Skip(header.size);
  ReadRecords(AddChunk(begin, header.size, *compression, header.Number<std::uint32_t>("size")),
              true);
}

void Rosbag::ReadConnection(const Header& header, Records* records) {
  const std::vector<std::uint8_t> data = records->Take(header.size);
  const auto fields = RosbagFields(ByteReader(path(), "the header of a connection", data));
  const auto type = fields.find("type");
  if (type == fields.end()) throw IoError(path(), "is damaged: a connection has no type");
  topics_[header.Number<std::uint32_t>("conn")] =
      AddTopic(header.Text("topic"), type->second, MessageEncoding::kRos1);
}

void Rosbag::ReadMessage(const Header& header, Records* records) {
  const auto topic = topics_.find(header.Number<std::uint32_t>("conn"));
  if (topic == topics_.end()) throw IoError(path(), "is damaged: a message has no connection");
  AddMessageOf(records, topic->second, header.Time("time"), header.size);
}

}  // namespace highwall
