#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include <highwall/internal/run_profile.h>

namespace [[gnu::visibility("default")]] highwall {

// A thread that runs tasks in the order of Post() and, while there are none, an idle task in small
// steps. The results of a task may be read once Wait() or Finish() has returned, or IsIdle() was
// true.
//
// Errors: an exception of a task or of the idle task is rethrown by the next Post(), Wait() or
// Finish(), once. The tasks waiting behind it are dropped; those posted later are run.
class BackgroundWorker {
 public:
  // stop: requested by RequestStop() and by the destructor. Long tasks poll it and return early.
  using Work = std::function<void(const std::stop_token& stop)>;
  // Returns true while there is more to do.
  using IdleTask = std::function<bool()>;

  // backlog: >= 1 tasks that may wait, else InvalidArgument. idle_task: the idle task, called
  // repeatedly while no task waits, until it returns false; then again only after the next task;
  // may be empty. label: of the thread.
  explicit BackgroundWorker(std::size_t backlog, IdleTask idle_task = {},
                            const ThreadLabel& label = {});
  // Requests a stop of the running task, waits for it, and drops the waiting tasks.
  ~BackgroundWorker();

  // Blocks while the backlog is full. Throws InvalidArgument after Finish().
  void Post(Work work);
  // Returns true if all posted tasks are finished. Does not throw; if true, Wait() does not block.
  bool IsIdle() const;
  // Blocks until all posted tasks are finished.
  void Wait();
  // Requests all tasks posted until now to end early; waiting tasks are still called, with stop
  // requested.
  void RequestStop();
  // Wait(), then ends the thread: the idle task is not called any more.
  void Finish();

 private:
  struct Piece {
    Work work;
    std::stop_token stop;
  };

  void Serve(const std::stop_token& end);
  // Runs one task, or one step of the idle task if there is none. lock: held before and after.
  void DoNext(std::unique_lock<std::mutex>& lock);
  void WaitUntilIdle(std::unique_lock<std::mutex>& lock);
  void ThrowError();

  const std::size_t backlog_;
  const IdleTask idle_task_;
  mutable std::mutex mutex_;  // protects all members below except the thread
  std::condition_variable_any changed_;
  std::deque<Piece> waiting_;
  std::stop_source stop_;  // for the tasks posted since the last RequestStop()
  bool busy_ = false;      // running a task
  bool has_idle_work_;     // idle_task_ has more to do
  std::exception_ptr error_;
  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace highwall
