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

// C++ objects that are not thread-safe, but give the interpreter's lock away while they work: other
// threads of Python may call them meanwhile.
namespace highwall::python {

namespace py = pybind11;

// Lets one call at a time in to an object.
class CallGate {
 public:
  // name: of the object's class in Python.
  explicit CallGate(std::string name) : name_(std::move(name)) {}
  CallGate(const CallGate&) = delete;
  CallGate& operator=(const CallGate&) = delete;

  // Held by a thread that works for the object: code in Python that it calls meanwhile must not
  // call the object in turn, which would wait for itself.
  class Work {
   public:
    explicit Work(const CallGate& gate);
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

   private:
    friend class CallGate;
    const CallGate& gate_;
    const Work* const outer_;  // of the same thread
  };

  // Waits for the calls of other threads. Without the interpreter's lock, for which they may wait.
  class Pass {
   public:
    explicit Pass(CallGate& gate) : lock_(gate.mutex_), work_(gate) {}

   private:
    const std::scoped_lock<std::mutex> lock_;
    const Work work_;
  };

  // Throws std::runtime_error (Python's RuntimeError) on a thread that works for the object.
  void RequireOutside() const;

  // A Python object that the object keeps alive. With the interpreter's lock.
  std::shared_ptr<Reference> Keep(py::object object) const {
    return std::make_shared<Reference>(references_, std::move(object));
  }
  References& references() const { return *references_; }

  // Code in Python that works for the object has raised what ends a program (KeyboardInterrupt,
  // SystemExit): the call that is under way, or the next one, ends as soon as it can and raises
  // that. Both with the interpreter's lock.
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

// An object behind a gate: what Python holds.
template <class T>
class Exclusive {
 public:
  // make(gate): the object, whose own calls of Python name the gate that they work for.
  template <class Make>
  Exclusive(std::string name, const Make& make)
      : gate_(std::make_shared<CallGate>(std::move(name))), object_(make(gate_)) {}

  // use(object), without the interpreter's lock and while no other call is under way. A reference
  // that it returns is copied. Raises what interrupted it, Ctrl-C included, rather than anything
  // that came of that.
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

  // The same on a thread that has no lock of the interpreter's, and raises nothing.
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

// The options of a solve that ends soon after Ctrl-C, or another interrupt of the gate's, which
// must outlive them.
SolveOptions Interruptible(SolveOptions options, CallGate& gate);

// A member function of T as one of Exclusive<T>, or of one that holds a class derived from T.
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
