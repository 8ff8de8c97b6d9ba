#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <highwall/core/error.h>

namespace highwall {

using ByteSpan = std::span<const std::uint8_t>;

// Reads numbers from bytes of a file, none of which is trusted: a read beyond the end throws
// IoError. Numbers are little-endian unless set otherwise.
class ByteReader {
 public:
  // path, name: of the bytes, for messages: "path: name ends early". All outlive this.
  ByteReader(const std::filesystem::path& path, std::string_view name, ByteSpan bytes)
      : path_(path), name_(name), bytes_(bytes) {}

  std::size_t position() const { return position_; }
  std::size_t rest() const { return bytes_.size() - position_; }
  void set_big_endian(bool big_endian) { big_endian_ = big_endian; }

  // Returns the next bytes.
  ByteSpan Take(std::uint64_t count) {
    if (count > rest()) Fail("ends early");
    const ByteSpan taken = bytes_.subspan(position_, static_cast<std::size_t>(count));
    position_ += taken.size();
    return taken;
  }

  void Skip(std::uint64_t count) { Take(count); }

  template <class T>
  requires std::integral<T> || std::floating_point<T> T Number() {
    const ByteSpan taken = Take(sizeof(T));
    std::uint8_t ordered[sizeof(T)];
    const bool reversed = big_endian_ != (std::endian::native == std::endian::big);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      ordered[i] = taken[reversed ? sizeof(T) - 1 - i : i];
    }
    T value;
    std::memcpy(&value, ordered, sizeof(T));
    return value;
  }

  // Returns the text after its length of 32 bits.
  std::string Text() {
    const ByteSpan taken = Take(Number<std::uint32_t>());
    return {taken.begin(), taken.end()};
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(path_, std::string(name_) + " " + what);
  }

 private:
  const std::filesystem::path& path_;
  std::string_view name_;
  ByteSpan bytes_;
  std::size_t position_ = 0;
  bool big_endian_ = false;
};

}  // namespace highwall
