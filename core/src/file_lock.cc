#include <highwall/core/file_lock.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace highwall {
namespace {

int FlagsOf(FileLock::Open how) {
  // For writing: some network file systems cannot lock a file that is opened to read only.
  constexpr int kFlags = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  if (how == FileLock::Open::kExisting) return kFlags;
  return kFlags | O_CREAT | (how == FileLock::Open::kNew ? O_EXCL : 0);
}

bool IsAt(int descriptor, const std::filesystem::path& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

FileLock::State Lock(int descriptor, const std::filesystem::path& path) {
  int result = 0;
  do {
    result = ::flock(descriptor, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  if (result != 0 && errno == EWOULDBLOCK) return FileLock::State::kTaken;
  if (!IsAt(descriptor, path)) return FileLock::State::kRemoved;
  return result == 0 ? FileLock::State::kHeld : FileLock::State::kNoLocks;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path, Open how)
    : descriptor_(::open(path.c_str(), FlagsOf(how), 0666)) {
  if (descriptor_ < 0) {
    error_ = errno;
    return;
  }
  state_ = Lock(descriptor_, path);
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace highwall
