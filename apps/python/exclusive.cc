#include "exclusive.h"

#include <chrono>
#include <stdexcept>

#include "interpreter.h"

namespace highwall::python {
namespace {

thread_local const CallGate::Work* innermost_work = nullptr;

}  // namespace

CallGate::Work::Work(const CallGate& gate) : gate_(gate), outer_(innermost_work) {
  innermost_work = this;
}

CallGate::Work::~Work() {
  innermost_work = outer_;
}

void CallGate::RequireOutside() const {
  for (const Work* work = innermost_work; work != nullptr; work = work->outer_) {
    if (&work->gate_ != this) continue;
    throw std::runtime_error("this " + name_ +
                             " is running and has called this code, which must not call it in "
                             "turn: store the request, and call it when its function has returned");
  }
}

void CallGate::Interrupt(py::error_already_set error) {
  if (!interrupt_) interrupt_ = std::move(error);
  interrupted_ = true;
}

void CallGate::RaiseInterrupt() {
  if (const auto interrupt = std::exchange(interrupt_, std::nullopt)) {
    interrupted_ = false;
    throw py::error_already_set(*interrupt);
  }
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

SolveOptions Interruptible(SolveOptions options, CallGate& gate) {
  using Clock = std::chrono::steady_clock;
  // Each check for signals waits for the GIL.
  static constexpr std::chrono::milliseconds kBetweenLooks(100);
  options.stop = &gate.interrupted();
  options.on_iteration = [&gate, last = Clock::now()](int, double) mutable {
    if (Clock::now() - last < kBetweenLooks) return;
    const InterpreterLock lock;
    if (lock.IsTaken() && PyErr_CheckSignals() != 0) gate.Interrupt(py::error_already_set());
    last = Clock::now();
  };
  return options;
}

}  // namespace highwall::python
