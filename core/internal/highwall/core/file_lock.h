#pragma once

#include <filesystem>

namespace [[gnu::visibility("default")]] highwall {

// A file that is open and locked (flock) during the lifetime of this object. Other processes see
// that it is in use: also those of other containers and, where the file system shares its locks,
// those of other machines. The operating system releases the lock when the process ends, however it
// ends.
class FileLock {
 public:
  enum class Open { kExisting, kNew, kAny };  // kNew: must not exist; kAny: created if missing
  enum class State {
    kHeld,
    kTaken,    // by another object or process
    kRemoved,  // the file was removed between its opening and the lock: try again
    kNoLocks,  // the file is open, but its file system has no locks
    kFailed,   // the file could not be opened, see error()
  };

  FileLock(const std::filesystem::path& path, Open how);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  State state() const { return state_; }
  int error() const { return error_; }  // errno; 0: none

 private:
  int descriptor_ = -1;
  int error_ = 0;
  State state_ = State::kFailed;
};

}  // namespace highwall
