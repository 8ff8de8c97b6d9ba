#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <ceres/manifold.h>
#include <highwall/core/error.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

// Type of a parameter block, known at run time: the Python counterpart of VariableTraits.
namespace highwall::python {

namespace py = pybind11;

enum class ValueKind { kPose, kOrthonormalLine, kSegment, kUnitDirection, kNumber, kVector };

struct ValueType {
  ValueKind kind = ValueKind::kVector;
  int size = 0;  // number of doubles of the block

  // Returns null for a Euclidean block.
  std::unique_ptr<ceres::Manifold> MakeManifold() const;
};

struct Value {
  ValueType type;
  std::vector<double> block;
};

// Maximum number of doubles of a vector in a graph: each size is a separate C++ type.
inline constexpr int kMaxVector = 16;

// Reads a Pose, OrthonormalLine, Segment3, UnitDirection, number, or one-dimensional array. Throws
// InvalidArgument for anything else.
Value ReadValue(const py::handle& value);
// Returns the Python object of a block.
py::object MakeValue(const ValueType& type, const double* block);
// Reads a class (Pose, ..., float) or a whole number, the length of a vector.
ValueType ReadValueType(const py::handle& type);

// Calls visit(value as the C++ type). Throws InvalidArgument for a vector longer than kMaxVector.
template <class Visit>
auto VisitValue(const Value& value, Visit visit) {
  const double* block = value.block.data();
  switch (value.type.kind) {
    case ValueKind::kPose:
      return visit(VariableTraits<Pose>::Read(block));
    case ValueKind::kOrthonormalLine:
      return visit(VariableTraits<OrthonormalLine>::Read(block));
    case ValueKind::kSegment:
      return visit(VariableTraits<Segment3>::Read(block));
    case ValueKind::kUnitDirection:
      return visit(VariableTraits<UnitDirection>::Read(block));
    case ValueKind::kNumber:
      return visit(*block);
    case ValueKind::kVector:
      break;
  }
  using Result = decltype(visit(*block));
  std::optional<Result> result;
  [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    const auto visit_size = [&]<int kSize>(std::integral_constant<int, kSize>) {
      if (value.type.size != kSize) return;
      result.emplace(visit(VariableTraits<Eigen::Matrix<double, kSize, 1>>::Read(block)));
    };
    (visit_size(std::integral_constant<int, kIndex + 1>()), ...);
  }
  (std::make_integer_sequence<int, kMaxVector>());
  HIGHWALL_REQUIRE(result, "a vector has 1 to " + std::to_string(kMaxVector) + " numbers, not " +
                               std::to_string(value.type.size));
  return *std::move(result);
}

}  // namespace highwall::python
