#pragma once

#include <pybind11/pybind11.h>

#include <optional>

// The interpreter's lock for threads that C++ has started. One that asks for it when the
// interpreter has ended is itself ended by Python, in the middle of C++, which ends the program as
// a crash.
namespace highwall::python {

namespace py = pybind11;

class InterpreterLock {
 public:
  // Not taken where the interpreter is about to end, but on the thread that ends it.
  InterpreterLock();
  ~InterpreterLock();
  InterpreterLock(const InterpreterLock&) = delete;
  InterpreterLock& operator=(const InterpreterLock&) = delete;

  // Else nothing of Python's may be touched.
  bool IsTaken() const { return lock_.has_value(); }

 private:
  std::optional<py::gil_scoped_acquire> lock_;
};

// When the interpreter is about to end, no more locks are given, and those that are taken waited
// for.
void EndLocksAtExit();

}  // namespace highwall::python
