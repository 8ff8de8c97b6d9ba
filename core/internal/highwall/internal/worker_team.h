#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include <highwall/internal/run_profile.h>

namespace [[gnu::visibility("default")]] highwall {

// A thread pool for tasks that are shorter than the start of a thread. Any free worker takes the
// next task, and no task waits for a thread that has not started: where the processors are busy,
// the caller runs most of the tasks itself.
class WorkerTeam {
 public:
  // work(worker, task): called once for each task; a worker runs its tasks sequentially.
  using Work = std::function<void(std::size_t worker, std::size_t task)>;

  // workers: >= 1. Worker 0 is the caller of Run(), each other worker has its own thread.
  // label: of these threads.
  explicit WorkerTeam(std::size_t workers, const ThreadLabel& label = {});

  // Runs tasks 0, 1, ..., `tasks` - 1 in parallel, started in this order; returns when all are
  // finished. Rethrows an exception of a task. Must not be called from two threads concurrently.
  void Run(std::size_t tasks, const Work& work);

 private:
  void Serve(std::size_t worker, std::stop_token stop);
  void Do(std::size_t worker, const Work& work, std::size_t tasks);

  std::mutex mutex_;
  std::condition_variable_any start_;
  std::condition_variable done_;
  std::atomic<std::size_t> next_ = 0;   // next task to start
  std::atomic<std::size_t> round_ = 0;  // number of calls of Run() with parallel work
  const Work* work_ = nullptr;          // null while no thread may join
  std::size_t tasks_ = 0;
  std::size_t active_ = 0;  // threads that have joined
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last, so that they end before what they use
};

}  // namespace highwall
