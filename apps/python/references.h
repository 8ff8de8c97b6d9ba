#pragma once

#include <pybind11/pybind11.h>

#include <list>
#include <memory>
#include <typeinfo>
#include <utility>

// Python objects kept alive by C++ objects and visible to Python's garbage collector: otherwise a
// cycle through them (the callback of a system is a method of the object that holds the system)
// would never be freed.
namespace highwall::python {

namespace py = pybind11;

// References of one C++ object. Requires the GIL.
class References {
 public:
  using Place = std::list<py::object>::iterator;

  References() = default;
  // Leaks references that remain after the interpreter has ended.
  ~References();
  References(const References&) = delete;
  References& operator=(const References&) = delete;

  Place Add(py::object object);
  void Remove(Place place);
  // Support the collector: Visit() visits each object, Clear() releases all, whose places are null
  // then.
  int Visit(visitproc visit, void* argument) const;
  void Clear();

 private:
  std::list<py::object> objects_;
};

// One reference, held during its lifetime.
class Reference {
 public:
  // Requires the GIL, as does Get().
  Reference(std::shared_ptr<References> references, py::object object)
      : references_(std::move(references)), place_(references_->Add(std::move(object))) {}
  // Acquires the GIL.
  ~Reference();
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  // Returns null if the collector has freed it.
  py::object Get() const { return *place_; }

 private:
  const std::shared_ptr<References> references_;
  const References::Place place_;
};

// Returns the C++ object of a Python object, or null if it has none (yet). Allocates nothing, as
// the collector requires.
template <class T>
T* ConstructedIn(PyObject* self) {
  auto* const instance = reinterpret_cast<py::detail::instance*>(self);
  if (!instance->simple_layout && instance->nonsimple.values_and_holders == nullptr) return nullptr;
  const auto* const type = py::detail::get_type_info(typeid(T), false);
  if (type == nullptr) return nullptr;
  const auto found = instance->get_value_and_holder(type, false);
  return found.inst != nullptr && found.holder_constructed() ? found.template value_ptr<T>()
                                                             : nullptr;
}

// Makes the references() of T visible to the collector, for the Python class of T.
template <class T>
py::custom_type_setup Collected() {
  return py::custom_type_setup([](PyHeapTypeObject* heap_type) {
    PyTypeObject& type = heap_type->ht_type;
    type.tp_flags |= Py_TPFLAGS_HAVE_GC;
    type.tp_traverse = [](PyObject* self, visitproc visit, void* argument) {
      const int stop = visit(reinterpret_cast<PyObject*>(Py_TYPE(self)), argument);
      const T* const object = stop == 0 ? ConstructedIn<T>(self) : nullptr;
      return object == nullptr ? stop : object->references().Visit(visit, argument);
    };
    type.tp_clear = [](PyObject* self) {
      if (T* const object = ConstructedIn<T>(self)) object->references().Clear();
      return 0;
    };
    // pybind11 leaves the object visible to the collector while its destructor runs.
    type.tp_dealloc = [](PyObject* self) {
      PyObject_GC_UnTrack(self);
      py::detail::pybind11_object_dealloc(self);
    };
  });
}

}  // namespace highwall::python
