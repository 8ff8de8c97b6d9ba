#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace highwall::internal {

// Threads that wait for work which is over before a new thread would have begun it.
class WorkerTeam {
 public:
  // parts: >= 1. One of them is done by the caller of Run(), the others have a thread each.
  explicit WorkerTeam(std::size_t parts);

  // work(part) for all parts, side by side; returns when all are done. Throws what a part threw.
  // Not to be called from two threads at once.
  void Run(const std::function<void(std::size_t part)>& work);

 private:
  void Serve(std::size_t part, std::stop_token stop);
  void Do(std::size_t part);

  std::mutex mutex_;
  std::condition_variable_any start_;
  std::condition_variable done_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::size_t round_ = 0;    // of work begun
  std::size_t pending_ = 0;  // parts of this round, the caller's left out
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last, so that they end before what they use
};

}  // namespace highwall::internal
