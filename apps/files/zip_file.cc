#include "files/zip_file.h"

#include <cstdint>
#include <span>
#include <utility>

#include <highwall/core/atomic_file.h>
#include <highwall/core/crc32.h>

namespace highwall::apps {
namespace {

constexpr int kVersion = 20;
constexpr std::uint32_t kDate = (0U << 9) | (1U << 5) | 1U;  // 1980-01-01: reproducible bytes

// Appends little-endian.
void Append(std::string& bytes, std::uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xFFU);
}

std::uint32_t Size(const std::string& text) {
  return static_cast<std::uint32_t>(text.size());
}

// Common part of a file's own header and its directory entry, starting with the required version.
std::string Description(const std::string& name, const std::string& content) {
  std::string bytes;
  Append(bytes, kVersion, 2);
  Append(bytes, 0, 2);  // flags
  Append(bytes, 0, 2);  // stored
  Append(bytes, 0, 2);  // time
  Append(bytes, kDate, 2);
  Append(bytes, Crc32(std::as_bytes(std::span(content))), 4);
  Append(bytes, Size(content), 4);
  Append(bytes, Size(content), 4);
  Append(bytes, Size(name), 2);
  Append(bytes, 0, 2);  // extra field
  return bytes;
}

}  // namespace

void ZipFile::Add(std::string name, std::string content) {
  entries_.push_back({std::move(name), std::move(content)});
}

void ZipFile::Write(const std::filesystem::path& path) const {
  std::string bytes, directory;
  for (const Entry& entry : entries_) {
    const std::string description = Description(entry.name, entry.content);
    Append(directory, 0x02014b50, 4);
    Append(directory, kVersion, 2);
    directory += description;
    Append(directory, 0, 2);  // comment
    Append(directory, 0, 2);  // disk
    Append(directory, 0, 2);  // internal attributes
    Append(directory, 0, 4);  // external attributes
    Append(directory, Size(bytes), 4);
    directory += entry.name;
    Append(bytes, 0x04034b50, 4);
    bytes += description + entry.name + entry.content;
  }
  std::string end;
  Append(end, 0x06054b50, 4);
  Append(end, 0, 4);  // disks
  Append(end, static_cast<std::uint32_t>(entries_.size()), 2);
  Append(end, static_cast<std::uint32_t>(entries_.size()), 2);
  Append(end, Size(directory), 4);
  Append(end, Size(bytes), 4);
  Append(end, 0, 2);  // comment
  AtomicFile file(path);
  file.stream() << bytes << directory << end;
  file.Commit();
}

}  // namespace highwall::apps
