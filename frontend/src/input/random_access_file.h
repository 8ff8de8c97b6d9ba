#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace highwall {

// A file of which parts are read, also by several threads at once.
class RandomAccessFile {
 public:
  // Throws IoError if it cannot be opened.
  explicit RandomAccessFile(std::filesystem::path path);
  ~RandomAccessFile();
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  // Whether the file has these bytes.
  bool Holds(std::uint64_t offset, std::uint64_t size) const {
    return offset <= size_ && size <= size_ - offset;
  }
  // Throws IoError if the file has no such bytes or they cannot be read.
  std::vector<std::uint8_t> Read(std::uint64_t offset, std::uint64_t size) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace highwall
