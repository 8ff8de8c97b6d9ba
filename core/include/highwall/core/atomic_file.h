#pragma once

#include <filesystem>
#include <fstream>

namespace highwall {

// A file that appears whole or not at all: the bytes go to a temporary name beside `path`, and
// Commit() puts it in place of whatever was there. Without Commit() the temporary is removed and
// the old file stays as it was.
class AtomicFile {
 public:
  // A link stays, what it leads to is replaced. Throws IoError if the temporary cannot be opened
  // (the folder must exist) or `path` is a device or a pipe.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Binary; write errors are found by Commit().
  std::ostream& stream() { return stream_; }
  // For writers that open a file by its name themselves (then do not use stream()).
  const std::filesystem::path& temporary() const { return temporary_; }

  // Throws IoError if anything could not be written (disk full), flushed or renamed; the old file
  // is then untouched.
  void Commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::ofstream stream_;
  bool committed_ = false;
};

}  // namespace highwall
