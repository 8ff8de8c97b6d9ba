#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <highwall/core/stamp.h>

#include "input/bag_file.h"
#include "input/byte_reader.h"

namespace highwall {

// Reads the fields of a message of ROS, one after the other, in the serialization of ROS 1 or in
// CDR, that of ROS 2. The two differ in the alignment of numbers, the end of strings, the order of
// bytes (CDR has both) and the header, whose sequence number ROS 2 has not.
// Source: ROS wiki, "msg", https://wiki.ros.org/msg; OMG, "Extensible and Dynamic Topic Types for
// DDS" 1.3, section 7.4.
class MessageReader {
 public:
  // path, name: of the message, for errors; bytes: its content. All outlive this. Throws IoError
  // for an encoding or a representation of CDR that is not known; all others if the message ends
  // early.
  MessageReader(const std::filesystem::path& path, std::string_view name, MessageEncoding encoding,
                ByteSpan bytes);

  bool is_cdr() const { return is_cdr_; }

  template <class T>
  T Number() {
    Align(sizeof(T));
    return reader_.Number<T>();
  }
  bool Flag() { return Number<std::uint8_t>() != 0; }
  std::string Text();
  // A sequence of bytes; those of the message.
  ByteSpan Bytes() { return reader_.Take(Number<std::uint32_t>()); }
  // The length of a sequence of elements that take at least `smallest` bytes each.
  std::size_t Count(std::size_t smallest);
  void SkipNumbers(std::size_t count, std::size_t size);
  // A time; 0 for one that no clock gives.
  Stamp Time();

  [[noreturn]] void Fail(const std::string& what) const { reader_.Fail(what); }

 private:
  void Align(std::size_t size);

  ByteReader reader_;
  bool is_cdr_ = false;
  std::size_t largest_alignment_ = 8;
};

// The stamp in the header with which a message begins: its first bytes, BagMessage::head. 0 for an
// encoding that is not known.
Stamp StampInHead(MessageEncoding encoding, ByteSpan head);

}  // namespace highwall
