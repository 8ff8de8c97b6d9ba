#pragma once

#include <pybind11/pybind11.h>

#include <optional>

// GIL for threads created by C++. If such a thread requests the GIL after the interpreter has
// ended, Python terminates it in the middle of C++ code, which crashes the program.
namespace highwall::python {

namespace py = pybind11;

class InterpreterLock {
 public:
  // Does not acquire the GIL if the interpreter is about to end, except on the thread that ends it.
  InterpreterLock();
  ~InterpreterLock();
  InterpreterLock(const InterpreterLock&) = delete;
  InterpreterLock& operator=(const InterpreterLock&) = delete;

  // If false, Python objects must not be accessed.
  bool IsTaken() const { return lock_.has_value(); }

 private:
  std::optional<py::gil_scoped_acquire> lock_;
};

// Before the interpreter ends, no more locks are given, and existing ones are waited for.
void EndLocksAtExit();

}  // namespace highwall::python
