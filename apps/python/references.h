#pragma once

#include <pybind11/pybind11.h>

#include <list>
#include <memory>
#include <typeinfo>
#include <utility>

// Python objects that C++ objects keep alive, where Python's garbage collector sees them: else a
// cycle through them (the callback of a system is a method of the object that holds the system)
// would never be freed.
namespace highwall::python {

namespace py = pybind11;

// Those of one C++ object. To be used with the interpreter's lock.
class References {
 public:
  using Place = std::list<py::object>::iterator;

  References() = default;
  // What is left when the interpreter has ended is not let go of.
  ~References();
  References(const References&) = delete;
  References& operator=(const References&) = delete;

  Place Add(py::object object);
  void Remove(Place place);
  // For the collector: visits each; and lets go of all, whose places are null then.
  int Visit(visitproc visit, void* argument) const;
  void Clear();

 private:
  std::list<py::object> objects_;
};

// One of them, for as long as this lives.
class Reference {
 public:
  // With the interpreter's lock, as Get().
  Reference(std::shared_ptr<References> references, py::object object)
      : references_(std::move(references)), place_(references_->Add(std::move(object))) {}
  // Takes the lock.
  ~Reference();
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  // Null where the collector has freed it.
  py::object Get() const { return *place_; }

 private:
  const std::shared_ptr<References> references_;
  const References::Place place_;
};

// The C++ object of a Python object; null as long as, and where, it has none. Makes nothing, as the
// collector asks for.
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

// For the class of T in Python, where T has references(): the collector sees them.
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
    // pybind11 leaves the object where the collector looks while its destructor runs.
    type.tp_dealloc = [](PyObject* self) {
      PyObject_GC_UnTrack(self);
      py::detail::pybind11_object_dealloc(self);
    };
  });
}

}  // namespace highwall::python
