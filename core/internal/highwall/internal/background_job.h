#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/internal/background_worker.h>
#include <highwall/internal/run_profile.h>

namespace [[gnu::visibility("default")]] highwall {

// A task that runs on its own thread or synchronously. Must be the last member of the class that
// holds its results: the task uses all of the other members and ends before they are destroyed.
class BackgroundTask {
 public:
  // work: see BackgroundWorker. Without `background` it is finished when the constructor returns.
  // label: of the thread.
  BackgroundTask(bool background, const BackgroundWorker::Work& work,
                 const ThreadLabel& label = {}) {
    if (!background) {
      work({});
      return;
    }
    worker_.emplace(1, BackgroundWorker::IdleTask(), label);
    worker_->Post(work);
  }

  // Requests the task to end early; does not wait.
  void Cancel() {
    if (worker_) worker_->RequestStop();
  }
  // Does not throw; if true, Wait() does not block.
  bool IsDone() const { return !worker_ || worker_->IsIdle(); }
  // Rethrows the exception that ended the task.
  void Wait() {
    if (worker_) worker_->Wait();
  }

 private:
  std::optional<BackgroundWorker> worker_;
};

// The job that is running or waiting to be applied, and the cancelled jobs that have not ended yet.
// Each of these holds its thread and its data, such as a copy of a map, so their number is limited
// to kMaxEnding. Job: has Cancel() and IsDone(), as BackgroundTask.
template <class Job>
class JobSlot {
 public:
  static constexpr std::size_t kMaxEnding = 2;

  bool IsEmpty() const { return job_ == nullptr; }
  // Returns true if the job may be cancelled and another one put without waiting.
  bool HasRoom() {
    DropEnded();
    return ending_.size() < kMaxEnding;
  }
  Job* operator->() { return job_.get(); }
  const Job* operator->() const { return job_.get(); }
  Job& operator*() { return *job_; }

  // Waits for the oldest cancelled job if there are too many.
  void Put(std::unique_ptr<Job> job) {
    DropEnded();
    while (ending_.size() > kMaxEnding) ending_.erase(ending_.begin());
    job_ = std::move(job);
  }
  std::unique_ptr<Job> Take() { return std::move(job_); }
  // Discards the result of the job; does not wait for its end.
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
