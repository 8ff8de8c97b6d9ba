#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <span>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include "exclusive.h"
#include "value.h"

namespace highwall::python {

// Base of factors written in Python: a class derived from Factor with
//   evaluate(self, *values) -> (residuals, [Jacobian of each value])
// The Jacobians are those in the tangent spaces, as Highwall's own factors return them in Python.
// Acquires the GIL while it evaluates. An exception of evaluate() becomes a std::runtime_error,
// except for those that end a program (KeyboardInterrupt, SystemExit), which propagate unchanged.
class PythonFactor : public ceres::CostFunction {
 public:
  // Throws InvalidArgument for no residuals or no values.
  PythonFactor(int residuals, const std::vector<ValueType>& types);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  const std::vector<ValueType>& types() const { return types_; }

 private:
  std::vector<ValueType> types_;
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;
};

// Returns the factor of a Python object, for use by the object behind the gate. A factor written in
// Python keeps its Python object alive, because the object's class is needed.
std::shared_ptr<ceres::CostFunction> ShareFactor(const py::object& factor,
                                                 const std::shared_ptr<CallGate>& gate);
// Returns null for None.
std::shared_ptr<ceres::LossFunction> ShareLoss(const py::object& loss);

}  // namespace highwall::python
