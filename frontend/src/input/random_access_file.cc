#include "input/random_access_file.h"

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <highwall/core/error.h>

namespace highwall {

RandomAccessFile::RandomAccessFile(std::filesystem::path path)
    : path_(std::move(path)), descriptor_(::open(path_.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    const std::string reason = std::generic_category().message(errno);
    if (descriptor_ >= 0) ::close(descriptor_);
    throw IoError(path_, "cannot be read: " + reason);
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RandomAccessFile::~RandomAccessFile() {
  ::close(descriptor_);
}

std::vector<std::uint8_t> RandomAccessFile::Read(std::uint64_t offset, std::uint64_t size) const {
  if (!Holds(offset, size)) {
    throw IoError(path_, "is truncated: it has no " + std::to_string(size) + " bytes at byte " +
                             std::to_string(offset));
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ::ssize_t count = ::pread(descriptor_, bytes.data() + done, bytes.size() - done,
                                    static_cast<::off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw IoError(path_, "cannot be read at byte " + std::to_string(offset + done));
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace highwall
