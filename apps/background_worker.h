#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace highwall::apps {

// A thread that does pieces of work in the order in which they came and, while there are none,
// something else a little at a time.
class BackgroundWorker {
 public:
  using Work = std::function<void()>;

  // backlog: >= 1 pieces that may wait. spare: called again and again while nothing waits, as long
  // as it returns true; then once more after the next piece.
  BackgroundWorker(std::size_t backlog, std::function<bool()> spare);

  // Waits while the backlog is full. Throws what earlier work threw.
  void Post(Work work);
  // Waits until all of it is done, and ends the thread. Throws what work threw. Call once, last;
  // without it work that still waits is given up.
  void Finish();

 private:
  void Serve(const std::stop_token& stop);

  std::size_t backlog_;
  std::function<bool()> spare_;
  std::mutex mutex_;  // of the four that follow
  std::condition_variable_any changed_;
  std::deque<Work> waiting_;
  bool busy_ = false;
  std::exception_ptr error_;
  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace highwall::apps
