#include "input/message_reader.h"

#include <algorithm>

namespace highwall {
namespace {

constexpr std::size_t kCdrHeader = 4;  // [byte] from which alignment counts

Stamp StampOf(std::uint32_t seconds, std::uint32_t nanoseconds) {
  const Stamp stamp = static_cast<Stamp>(seconds) * 1'000'000'000 + nanoseconds;
  return std::min(stamp, kMaxStamp);
}

}  // namespace

MessageReader::MessageReader(const std::filesystem::path& path, std::string_view name,
                             MessageEncoding encoding, ByteSpan bytes)
    : reader_(path, name, bytes), is_cdr_(encoding == MessageEncoding::kCdr) {
  if (encoding == MessageEncoding::kOther) {
    Fail("is neither in the serialization of ROS 1 nor in CDR");
  }
  if (!is_cdr_) return;
  const ByteSpan header = reader_.Take(kCdrHeader);
  constexpr std::uint8_t kPlainCdr2 = 6;  // and 7: plain CDR of version 2
  if (header[0] != 0 || (header[1] > 1 && (header[1] & ~1) != kPlainCdr2)) {
    Fail("is in another representation of CDR than the plain one");
  }
  if (header[1] > 1) largest_alignment_ = 4;
  reader_.set_big_endian((header[1] & 1) == 0);
}

void MessageReader::Align(std::size_t size) {
  if (!is_cdr_) return;
  const std::size_t alignment = std::min(size, largest_alignment_);
  const std::size_t beyond = (reader_.position() - kCdrHeader) % alignment;
  if (beyond > 0) reader_.Skip(alignment - beyond);
}

std::string MessageReader::Text() {
  const ByteSpan bytes = Bytes();
  std::string text(bytes.begin(), bytes.end());
  if (is_cdr_ && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::size_t MessageReader::Count(std::size_t smallest) {
  const std::size_t count = Number<std::uint32_t>();
  if (count > reader_.rest() / smallest) Fail("ends early");
  return count;
}

void MessageReader::SkipNumbers(std::size_t count, std::size_t size) {
  Align(size);
  reader_.Skip(count * size);
}

Stamp MessageReader::Time() {
  const auto seconds = Number<std::uint32_t>(), nanoseconds = Number<std::uint32_t>();
  return StampOf(seconds, nanoseconds);
}

Stamp StampInHead(MessageEncoding encoding, ByteSpan head) {
  if (encoding == MessageEncoding::kOther || head.size() < BagMessage::kHead) return 0;
  const std::filesystem::path none;
  ByteReader reader(none, "", head);      // which cannot end early
  const ByteSpan first = reader.Take(4);  // the sequence number of ROS 1, or the header of CDR
  reader.set_big_endian(encoding == MessageEncoding::kCdr && (first[1] & 1) == 0);
  const auto seconds = reader.Number<std::uint32_t>(), nanoseconds = reader.Number<std::uint32_t>();
  return StampOf(seconds, nanoseconds);
}

}  // namespace highwall
