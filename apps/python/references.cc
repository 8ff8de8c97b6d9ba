#include "references.h"

#include <vector>

#include "interpreter.h"

namespace highwall::python {

References::~References() {
  for (py::object& object : objects_) object.release();
}

References::Place References::Add(py::object object) {
  return objects_.insert(objects_.end(), std::move(object));
}

void References::Remove(Place place) {
  const py::object removed = std::move(*place);  // its destruction may re-enter this function
  objects_.erase(place);
}

int References::Visit(visitproc visit, void* argument) const {
  for (const py::object& object : objects_) {
    if (!object) continue;
    if (const int stop = visit(object.ptr(), argument)) return stop;
  }
  return 0;
}

void References::Clear() {
  std::vector<py::object> removed;
  for (py::object& object : objects_) removed.push_back(std::move(object));
}

Reference::~Reference() {
  const InterpreterLock lock;
  if (lock.IsTaken()) references_->Remove(place_);  // else leaked at exit
}

}  // namespace highwall::python
