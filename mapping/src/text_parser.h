#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <highwall/core/error.h>

namespace highwall::internal {

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

// Splits a line at spaces and tabs.
inline std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(" \t"); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(" \t", end);
  }
  return words;
}

// Returns false unless the whole `text` is one number of the type of `value`.
template <typename T>
bool ParseNumber(std::string_view text, T& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size();
}

}  // namespace highwall::internal
