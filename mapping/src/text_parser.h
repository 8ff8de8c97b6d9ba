#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall::internal {

inline constexpr std::string_view kBetweenWords = " \t";

// Cursor in a file in memory, which is read line by line or in blocks of bytes; it counts the lines
// for error messages.
class FileCursor {
 public:
  // Throws IoError if the file cannot be read.
  explicit FileCursor(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw IoError(path, "is a folder, not a file");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw IoError(path, "cannot be read");
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
  }

  // Returns the rest of the line without its end and advances to the next line. Throws IoError at
  // the end of the file.
  std::string_view Line() {
    ++line_;
    if (at_ >= bytes_.size()) Fail("the file ends here");
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view line(bytes_.data() + at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  // Returns the next `count` bytes. Throws IoError if fewer are left.
  const char* Bytes(std::size_t count) {
    if (bytes_.size() - at_ < count) Fail("truncated: data are missing after it");
    at_ += count;
    return bytes_.data() + (at_ - count);
  }
  [[noreturn]] void Fail(const std::string& what) const { throw IoError(path_, line_, what); }

 private:
  std::filesystem::path path_;
  std::string bytes_;
  std::size_t at_ = 0;
  std::int64_t line_ = 0;
};

}  // namespace highwall::internal
