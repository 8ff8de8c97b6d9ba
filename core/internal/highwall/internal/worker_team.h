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

namespace [[gnu::visibility("default")]] highwall {

// Threads that share out tasks which are over before a new thread would have begun. Whoever is free
// takes the next task, and nobody waits for a thread that has not begun: where the processors are
// busy, the caller does most of the tasks itself.
class WorkerTeam {
 public:
  // work(worker, task): each task once; a worker does its tasks one after the other.
  using Work = std::function<void(std::size_t worker, std::size_t task)>;

  // workers: >= 1. Worker 0 is the caller of Run(), the others have a thread each.
  explicit WorkerTeam(std::size_t workers);

  // Does tasks 0, 1, ..., `tasks` - 1, begun in this order, side by side; returns when all are
  // done. Throws what a task threw. Not to be called from two threads at once.
  void Run(std::size_t tasks, const Work& work);

 private:
  void Serve(std::size_t worker, std::stop_token stop);
  void Do(std::size_t worker, const Work& work, std::size_t tasks);

  std::mutex mutex_;
  std::condition_variable_any start_;
  std::condition_variable done_;
  std::atomic<std::size_t> next_ = 0;   // task to begin
  std::atomic<std::size_t> round_ = 0;  // of work begun
  const Work* work_ = nullptr;          // null while no thread may join
  std::size_t tasks_ = 0;
  std::size_t active_ = 0;  // threads that have joined
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last, so that they end before what they use
};

}  // namespace highwall
