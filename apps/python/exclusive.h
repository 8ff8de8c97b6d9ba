#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include <highwall/core/solver.h>

#include "references.h"

// Wrappers of C++ objects that are not thread-safe but release the GIL while they work, so that
// other Python threads may call them in the meantime.
namespace highwall::python {

namespace py = pybind11;

// Mutual exclusion of the calls of one object.
class CallGate {
 public:
  // name: Python class of the object.
  explicit CallGate(std::string name) : name_(std::move(name)) {}
  CallGate(const CallGate&) = delete;
  CallGate& operator=(const CallGate&) = delete;

  // Marks a thread as working for the object. Python code called by that thread must not call the
  // object, which would deadlock.
  class Work {
   public:
    explicit Work(const CallGate& gate);
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

   private:
    friend class CallGate;
    const CallGate& gate_;
    const Work* const outer_;  // on the same thread
  };

  // Waits for the calls of other threads. The GIL must not be held, because those may wait for it.
  class Pass {
   public:
    explicit Pass(CallGate& gate) : lock_(gate.mutex_), work_(gate) {}

   private:
    const std::scoped_lock<std::mutex> lock_;
    const Work work_;
  };

  // Throws std::runtime_error (Python's RuntimeError) on a thread that works for the object.
  void RequireOutside() const;

  // Keeps a Python object alive as long as the C++ object. Requires the GIL.
  std::shared_ptr<Reference> Keep(py::object object) const {
    return std::make_shared<Reference>(references_, std::move(object));
  }
  References& references() const { return *references_; }

  // Interrupt() records that Python code called by the object has raised an exception that ends a
  // program (KeyboardInterrupt, SystemExit): the current or next call ends as soon as possible and
  // raises it by RaiseInterrupt(). Both require the GIL.
  void Interrupt(py::error_already_set error);
  void RaiseInterrupt();
  const std::atomic<bool>& interrupted() const { return interrupted_; }

 private:
  const std::string name_;
  std::mutex mutex_;
  std::optional<py::error_already_set> interrupt_;
  std::atomic<bool> interrupted_ = false;
  const std::shared_ptr<References> references_ = std::make_shared<References>();
};

// Object with a gate, as held by Python.
template <class T>
class Exclusive {
 public:
  // make(gate): returns the object, whose own Python calls are registered with that gate.
  template <class Make>
  Exclusive(std::string name, const Make& make)
      : gate_(std::make_shared<CallGate>(std::move(name))), object_(make(gate_)) {}

  // Calls use(object) without the GIL and exclusively. A returned reference is copied. If the call
  // was interrupted, including by Ctrl-C, that exception is raised instead of any resulting error.
  template <class Use>
  auto Call(const Use& use) {
    gate_->RequireOutside();
    try {
      if constexpr (std::is_void_v<decltype(Unlocked(use))>) {
        Unlocked(use);
        gate_->RaiseInterrupt();
      } else {
        auto result = Unlocked(use);
        gate_->RaiseInterrupt();
        return result;
      }
    } catch (...) {
      gate_->RaiseInterrupt();
      throw;
    }
  }

  // Does the same on a thread that does not hold the GIL, and raises no interrupt.
  template <class Use>
  auto Enter(const Use& use) {
    const CallGate::Pass pass(*gate_);
    return use(object_);
  }

  const std::shared_ptr<CallGate>& gate() const { return gate_; }
  References& references() const { return gate_->references(); }

 private:
  template <class Use>
  auto Unlocked(const Use& use) {
    const py::gil_scoped_release unlocked;
    return Enter(use);
  }

  const std::shared_ptr<CallGate> gate_;
  T object_;
};

// Returns solver options that stop soon after Ctrl-C or another interrupt of the gate, which must
// outlive them.
SolveOptions Interruptible(SolveOptions options, CallGate& gate);

// Binds a member function of T to Exclusive<T>, or to that of a class derived from T.
template <class Held, class T, class Result, class... Arguments>
auto Exclusively(Result (T::*function)(Arguments...) const) {
  return [function](Exclusive<Held>& self, Arguments... arguments) {
    return self.Call([&](const T& object) { return (object.*function)(arguments...); });
  };
}
template <class Held, class T, class Result, class... Arguments>
auto Exclusively(Result (T::*function)(Arguments...)) {
  return [function](Exclusive<Held>& self, Arguments... arguments) {
    return self.Call([&](T& object) { return (object.*function)(arguments...); });
  };
}

}  // namespace highwall::python
