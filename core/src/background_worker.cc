#include <highwall/internal/background_worker.h>

#include <utility>

#include <highwall/core/error.h>

namespace highwall {

BackgroundWorker::BackgroundWorker(std::size_t backlog, IdleTask idle_task,
                                   const ThreadLabel& label)
    : backlog_(backlog), idle_task_(std::move(idle_task)), has_idle_work_(idle_task_ != nullptr) {
  HIGHWALL_REQUIRE(backlog >= 1, "the backlog of a BackgroundWorker must be at least 1");
  thread_ = std::jthread([this, label](const std::stop_token& end) {
    SetUpThread(label);
    const ProfiledThread profiled(label);
    Serve(end);
  });
}

BackgroundWorker::~BackgroundWorker() {
  // The thread first: a task that returns early must not start the next one.
  thread_.request_stop();
  RequestStop();
}

void BackgroundWorker::Post(Work work) {
  HIGHWALL_REQUIRE(thread_.joinable(), "BackgroundWorker: Post() after Finish()");
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.size() < backlog_; });
  ThrowError();
  waiting_.push_back({std::move(work), stop_.get_token()});
  changed_.notify_all();
}

bool BackgroundWorker::IsIdle() const {
  const std::lock_guard lock(mutex_);
  return waiting_.empty() && !busy_;
}

void BackgroundWorker::Wait() {
  std::unique_lock lock(mutex_);
  WaitUntilIdle(lock);
  ThrowError();
}

void BackgroundWorker::RequestStop() {
  std::stop_source posted;
  {
    const std::lock_guard lock(mutex_);
    std::swap(posted, stop_);
  }
  posted.request_stop();
}

void BackgroundWorker::Finish() {
  std::unique_lock lock(mutex_);
  WaitUntilIdle(lock);
  lock.unlock();
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  ThrowError();
}

void BackgroundWorker::WaitUntilIdle(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [this] { return waiting_.empty() && !busy_; });
}

void BackgroundWorker::ThrowError() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void BackgroundWorker::Serve(const std::stop_token& end) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, end, [this] { return has_idle_work_ || !waiting_.empty(); }) &&
         !end.stop_requested()) {
    DoNext(lock);
  }
}

void BackgroundWorker::DoNext(std::unique_lock<std::mutex>& lock) {
  Piece piece;
  if (!waiting_.empty()) {
    piece = std::move(waiting_.front());
    waiting_.pop_front();
    busy_ = true;
    changed_.notify_all();
  }
  lock.unlock();
  bool more = idle_task_ != nullptr;
  std::exception_ptr error;
  try {
    if (piece.work) {
      piece.work(piece.stop);
    } else {
      more = idle_task_();
    }
  } catch (...) {
    error = std::current_exception();
  }
  piece = {};  // releases its captures before it is reported as finished
  lock.lock();
  busy_ = false;
  has_idle_work_ = more && !error;
  if (error) {
    error_ = error;
    waiting_.clear();
  }
  changed_.notify_all();
}

}  // namespace highwall
