#include <highwall/core/atomic_file.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <sstream>
#include <string>
#include <system_error>

#include <highwall/core/error.h>

namespace highwall {
namespace {

// No other live object has this address in this process: writers of one path do not meet.
std::string UniqueSuffix(const AtomicFile* file) {
  std::ostringstream text;
  text << ::getpid() << "-" << static_cast<const void*>(file);
  return text.str();
}

// What a link leads to: it stays a link. A device or a pipe must not be replaced by a file.
std::filesystem::path Target(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return path;
  const bool replaceable =
      std::filesystem::is_regular_file(path, error) || std::filesystem::is_directory(path, error);
  if (!replaceable) throw IoError(path, "is not a regular file");
  if (!std::filesystem::is_symlink(path, error)) return path;
  return std::filesystem::canonical(path);
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& path)
    : path_(Target(path)),
      // The extension stays last: writers that choose a format by it must see it.
      temporary_(path_.parent_path() / ("." + path_.stem().string() + "." + UniqueSuffix(this) +
                                        path_.extension().string())) {
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::Commit() {
  errno = 0;
  stream_.close();
  if (stream_.fail()) {
    throw IoError(path_, std::string("could not be written whole: ") +
                             (errno != 0 ? std::strerror(errno) : "write failed"));
  }
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) throw IoError(path_, "could not be put in place: " + error.message());
  committed_ = true;
}

}  // namespace highwall
