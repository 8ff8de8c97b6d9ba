#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/internal/background_worker.h>

namespace [[gnu::visibility("default")]] highwall {

// One piece of work, on a thread of its own or at once. A member of what holds its results, and the
// last: the work uses all of the others, and ends first.
class BackgroundTask {
 public:
  // work: see BackgroundWorker. At once it is done when the constructor returns.
  BackgroundTask(bool background, const BackgroundWorker::Work& work) {
    if (!background) {
      work({});
      return;
    }
    worker_.emplace(1);
    worker_->Post(work);
  }

  // Asks it to end early; does not wait.
  void Cancel() {
    if (worker_) worker_->RequestStop();
  }
  // Does not throw: Wait() then does not wait.
  bool IsDone() const { return !worker_ || worker_->IsIdle(); }
  // Throws what ended the work.
  void Wait() {
    if (worker_) worker_->Wait();
  }

 private:
  std::optional<BackgroundWorker> worker_;
};

// The job that is under way, or waits to be applied, and those that were cancelled and have still
// to end: each holds its thread and what it works on, such as a copy of a map, so that there are
// no more than kMaxEnding. Job: has Cancel() and IsDone(), as BackgroundTask.
template <class Job>
class JobSlot {
 public:
  static constexpr std::size_t kMaxEnding = 2;

  bool IsEmpty() const { return job_ == nullptr; }
  // Whether the job may be cancelled and another one put without a wait.
  bool HasRoom() {
    DropEnded();
    return ending_.size() < kMaxEnding;
  }
  Job* operator->() { return job_.get(); }
  const Job* operator->() const { return job_.get(); }
  Job& operator*() { return *job_; }

  // Waits for the oldest of those that were cancelled where there are too many.
  void Put(std::unique_ptr<Job> job) {
    DropEnded();
    while (ending_.size() > kMaxEnding) ending_.erase(ending_.begin());
    job_ = std::move(job);
  }
  std::unique_ptr<Job> Take() { return std::move(job_); }
  // Nothing of it will be asked for; does not wait for its end.
  void Cancel() {
    if (!job_) return;
    job_->Cancel();
    ending_.push_back(std::move(job_));
    DropEnded();
  }

 private:
  void DropEnded() {
    std::erase_if(ending_, [](const auto& cancelled) { return cancelled->IsDone(); });
  }

  std::unique_ptr<Job> job_;
  std::vector<std::unique_ptr<Job>> ending_;
};

}  // namespace highwall
