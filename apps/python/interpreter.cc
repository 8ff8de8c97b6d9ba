#include "interpreter.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace highwall::python {
namespace {

// Process-wide, like the interpreter.
struct Locks {
  std::mutex mutex;
  std::condition_variable returned;
  int taken = 0;
  std::optional<std::thread::id> ended_by;
};

Locks& AllLocks() {
  static Locks locks;
  return locks;
}

void EndLocks() {
  // A call of a daemon thread may never return.
  constexpr std::chrono::seconds kLongest(2);
  const py::gil_scoped_release unlocked;  // lets the holders of locks continue
  Locks& locks = AllLocks();
  std::unique_lock lock(locks.mutex);
  locks.ended_by = std::this_thread::get_id();
  locks.returned.wait_for(lock, kLongest, [&] { return locks.taken == 0; });
}

}  // namespace

InterpreterLock::InterpreterLock() {
  Locks& locks = AllLocks();
  {
    const std::scoped_lock lock(locks.mutex);
    if (locks.ended_by && *locks.ended_by != std::this_thread::get_id()) return;
    ++locks.taken;
  }
  lock_.emplace();
}

InterpreterLock::~InterpreterLock() {
  if (!lock_) return;
  lock_.reset();
  Locks& locks = AllLocks();
  const std::scoped_lock lock(locks.mutex);
  --locks.taken;
  locks.returned.notify_all();
}

void EndLocksAtExit() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&EndLocks));
}

}  // namespace highwall::python
