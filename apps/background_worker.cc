#include "background_worker.h"

#include <utility>

namespace highwall::apps {

BackgroundWorker::BackgroundWorker(std::size_t backlog, std::function<bool()> spare)
    : backlog_(backlog),
      spare_(std::move(spare)),
      thread_([this](const std::stop_token& stop) { Serve(stop); }) {}

void BackgroundWorker::Post(Work work) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return error_ || waiting_.size() < backlog_; });
  if (error_) std::rethrow_exception(error_);
  waiting_.push_back(std::move(work));
  changed_.notify_all();
}

void BackgroundWorker::Finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return error_ || (waiting_.empty() && !busy_); });
  lock.unlock();
  thread_.request_stop();
  thread_.join();
  if (error_) std::rethrow_exception(error_);
}

void BackgroundWorker::Serve(const std::stop_token& stop) {
  bool spare_time = true;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return spare_time || !waiting_.empty(); }) &&
         !stop.stop_requested()) {
    Work work;
    if (!waiting_.empty()) {
      work = std::move(waiting_.front());
      waiting_.pop_front();
      busy_ = true;
      changed_.notify_all();
    }
    lock.unlock();
    std::exception_ptr error;
    try {
      if (work) {
        work();
        spare_time = true;
      } else {
        spare_time = spare_();
      }
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    error_ = error;
    changed_.notify_all();
    if (error_) return;
  }
}

}  // namespace highwall::apps
