#include "value.h"

#include <pybind11/eigen.h>

#include <algorithm>
#include <string>

#include <highwall/core/error.h>

namespace highwall::python {
namespace {

template <class T>
Value OwnBlock(ValueKind kind, const T& value) {
  return {.type = {kind, T::kSize},
          .block = std::vector<double>(value.data(), value.data() + T::kSize)};
}

}  // namespace

std::unique_ptr<ceres::Manifold> ValueType::MakeManifold() const {
  switch (kind) {
    case ValueKind::kPose:
      return std::make_unique<PoseManifold>();
    case ValueKind::kOrthonormalLine:
      return std::make_unique<LineManifold>();
    case ValueKind::kUnitDirection:
      return std::make_unique<UnitDirectionManifold>();
    case ValueKind::kSegment:
    case ValueKind::kNumber:
    case ValueKind::kVector:
      break;
  }
  return nullptr;
}

Value ReadValue(const py::handle& value) {
  if (py::isinstance<Pose>(value)) return OwnBlock(ValueKind::kPose, value.cast<Pose>());
  if (py::isinstance<OrthonormalLine>(value)) {
    return OwnBlock(ValueKind::kOrthonormalLine, value.cast<OrthonormalLine>());
  }
  if (py::isinstance<Segment3>(value)) return OwnBlock(ValueKind::kSegment, value.cast<Segment3>());
  if (py::isinstance<UnitDirection>(value)) {
    return OwnBlock(ValueKind::kUnitDirection, value.cast<UnitDirection>());
  }
  const bool number = PyFloat_Check(value.ptr()) || PyLong_Check(value.ptr());
  if (number) return {.type = {ValueKind::kNumber, 1}, .block = {value.cast<double>()}};
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array) PyErr_Clear();
  HIGHWALL_REQUIRE(array && array.ndim() == 1 && array.size() > 0,
                   "a variable is a Pose, an OrthonormalLine, a Segment3, a UnitDirection, a "
                   "number or an array of one dimension, not " +
                       py::repr(value.get_type()).cast<std::string>());
  return {.type = {ValueKind::kVector, static_cast<int>(array.size())},
          .block = std::vector<double>(array.data(), array.data() + array.size())};
}

py::object MakeValue(const ValueType& type, const double* block) {
  switch (type.kind) {
    case ValueKind::kPose:
      return py::cast(VariableTraits<Pose>::Read(block));
    case ValueKind::kOrthonormalLine:
      return py::cast(VariableTraits<OrthonormalLine>::Read(block));
    case ValueKind::kSegment:
      return py::cast(VariableTraits<Segment3>::Read(block));
    case ValueKind::kUnitDirection:
      return py::cast(VariableTraits<UnitDirection>::Read(block));
    case ValueKind::kNumber:
      return py::float_(*block);
    case ValueKind::kVector:
      break;
  }
  return py::cast(Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(block, type.size)));
}

ValueType ReadValueType(const py::handle& type) {
  if (type.is(py::type::of<Pose>())) return {ValueKind::kPose, Pose::kSize};
  if (type.is(py::type::of<OrthonormalLine>())) {
    return {ValueKind::kOrthonormalLine, OrthonormalLine::kSize};
  }
  if (type.is(py::type::of<Segment3>())) return {ValueKind::kSegment, Segment3::kSize};
  if (type.is(py::type::of<UnitDirection>())) {
    return {ValueKind::kUnitDirection, UnitDirection::kSize};
  }
  if (type.ptr() == reinterpret_cast<PyObject*>(&PyFloat_Type)) return {ValueKind::kNumber, 1};
  HIGHWALL_REQUIRE(PyLong_Check(type.ptr()) && type.cast<int>() > 0,
                   "the type of a variable is Pose, OrthonormalLine, Segment3, UnitDirection, "
                   "float or the length of a vector, not " +
                       py::repr(type).cast<std::string>());
  return {ValueKind::kVector, type.cast<int>()};
}

}  // namespace highwall::python
