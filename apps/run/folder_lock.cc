#include "run/folder_lock.h"

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::apps {

FolderLock::FolderLock(std::filesystem::path folder)
    : folder_(std::move(folder)), before_(ContentOf(folder_)) {
  using State = FileLock::State;
  const auto is_gone = [this] {  // removed by the previous command together with its folder
    return lock_->state() == State::kRemoved || lock_->error() == ENOENT;
  };
  constexpr int kAttempts = 100;
  for (int i = 0; i == 0 || (is_gone() && i < kAttempts); ++i) {
    MakeFolder();
    lock_.emplace(folder_ / kLockFile, FileLock::Open::kAny);
  }
  if (lock_->state() == State::kTaken) {
    throw IoError(folder_,
                  "another command of Highwall is writing to this folder: wait for its end, or "
                  "choose another folder");
  }
  if (lock_->state() != State::kHeld && lock_->state() != State::kNoLocks) {
    throw IoError(folder_, std::string("cannot be written to: ") + std::strerror(lock_->error()));
  }
}

FolderLock::~FolderLock() {
  std::error_code ignored;
  const bool is_mark =
      before_ != FolderContent::kForeign && ContentOf(folder_) == FolderContent::kUnfinished;
  if (!is_mark) std::filesystem::remove(folder_ / kLockFile, ignored);  // while locked
  lock_.reset();
  for (; !made_.empty(); made_.pop_back()) std::filesystem::remove(made_.back(), ignored);
}

void FolderLock::MakeFolder() {
  std::error_code error;
  std::vector<std::filesystem::path> missing;
  std::filesystem::path path = std::filesystem::absolute(folder_, error).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "run/" -> "run"
  for (; path.has_relative_path() && !std::filesystem::exists(path, error);
       path = path.parent_path()) {
    missing.push_back(path);
  }
  std::filesystem::create_directories(folder_, error);
  if (error) throw IoError(folder_, "cannot be made: " + error.message());
  made_.insert(made_.end(), missing.rbegin(), missing.rend());
}

}  // namespace highwall::apps
