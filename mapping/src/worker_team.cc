#include "worker_team.h"

#include <utility>

namespace highwall::internal {

WorkerTeam::WorkerTeam(std::size_t parts) {
  for (std::size_t part = 1; part < parts; ++part) {
    threads_.emplace_back([this, part](std::stop_token stop) { Serve(part, std::move(stop)); });
  }
}

void WorkerTeam::Run(const std::function<void(std::size_t)>& work) {
  if (threads_.empty()) return work(0);
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    pending_ = threads_.size();
    ++round_;
  }
  start_.notify_all();
  Do(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return pending_ == 0; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void WorkerTeam::Serve(std::size_t part, std::stop_token stop) {
  for (std::size_t served = 0;; ++served) {
    {
      std::unique_lock lock(mutex_);
      if (!start_.wait(lock, stop, [&] { return round_ != served; })) return;
    }
    Do(part);
    const std::lock_guard lock(mutex_);
    if (--pending_ == 0) done_.notify_one();
  }
}

void WorkerTeam::Do(std::size_t part) {
  try {
    (*work_)(part);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
  }
}

}  // namespace highwall::internal
