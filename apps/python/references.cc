#include "references.h"

#include <vector>

namespace highwall::python {

References::Place References::Add(py::object object) {
  return objects_.insert(objects_.end(), std::move(object));
}

void References::Remove(Place place) {
  const py::object removed = std::move(*place);  // what goes with it may come back here
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
  const py::gil_scoped_acquire lock;
  references_->Remove(place_);
}

}  // namespace highwall::python
