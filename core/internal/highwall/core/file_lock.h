#pragma once

#include <filesystem>

namespace [[gnu::visibility("default")]] highwall {

// A file that is open and locked (flock) while this lives. Other processes see that it is in use:
// those of other containers too and, where the file system shares its locks, those of other
// machines. The system releases the lock with the process, however that ends.
class FileLock {
 public:
  enum class Open { kExisting, kNew, kAny };  // kNew: it must not be there, kAny: made if missing
  enum class State {
    kHeld,
    kTaken,    // by another object or process
    kRemoved,  // somebody removed the file between its opening and the lock: try again
    kNoLocks,  // it is open, but its file system has no locks
    kFailed,   // it could not be opened, see error()
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
