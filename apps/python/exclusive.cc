#include "exclusive.h"

#include <stdexcept>

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
                             " is at work and has called this code, which must not call it in "
                             "turn: note what is to be asked, and ask when its call has returned");
  }
}

}  // namespace highwall::python
