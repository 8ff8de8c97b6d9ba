#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace [[gnu::visibility("default")]] highwall {

// A thread that does pieces of work in the order in which they came and, while there are none,
// something else a little at a time. Results are the work's own affair: what it writes may be read
// when Wait() or Finish() has returned, or IsIdle() was true.
//
// Errors: what work or spare throws is thrown by the next Post(), Wait() or Finish(), once. The
// pieces that waited behind it are dropped; those that are posted later are done.
class BackgroundWorker {
 public:
  // stop: requested by RequestStop() and by the end of the worker. Work that takes long looks at it
  // and returns early.
  using Work = std::function<void(const std::stop_token& stop)>;
  // True while there is more to do.
  using SpareWork = std::function<bool()>;

  // backlog: >= 1 pieces that may wait, else InvalidArgument. spare: called again and again while
  // nothing waits, as long as it returns true; then once more after the next piece; may be empty.
  explicit BackgroundWorker(std::size_t backlog, SpareWork spare = {});
  // Requests a stop of the piece that is being done, waits for it, and drops those that wait.
  ~BackgroundWorker();

  // Waits while the backlog is full. Throws InvalidArgument after Finish().
  void Post(Work work);
  // Whether all that was posted is done. Does not throw: Wait() then does not wait.
  bool IsIdle() const;
  // Until all that was posted is done.
  void Wait();
  // Asks everything that was posted so far to end early; what waits is still called, and told so.
  void RequestStop();
  // Wait(), and the end of the thread: spare is not called any more.
  void Finish();

 private:
  struct Piece {
    Work work;
    std::stop_token stop;
  };

  void Serve(const std::stop_token& end);
  // Does one piece, or some spare work where there is none. lock: held before and after.
  void DoNext(std::unique_lock<std::mutex>& lock);
  void WaitUntilIdle(std::unique_lock<std::mutex>& lock);
  void ThrowError();

  const std::size_t backlog_;
  const SpareWork spare_;
  mutable std::mutex mutex_;  // of all that follows but the thread
  std::condition_variable_any changed_;
  std::deque<Piece> waiting_;
  std::stop_source stop_;  // of the pieces posted since the last RequestStop()
  bool busy_ = false;      // with a piece
  bool has_spare_;         // work to do
  std::exception_ptr error_;
  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace highwall
