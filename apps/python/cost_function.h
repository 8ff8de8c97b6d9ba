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

// A factor that is written in Python: a class derived from Factor with
//   evaluate(self, *values) -> (residuals, [Jacobian of each value])
// where the Jacobians are those in the tangent spaces, as Highwall's own factors give them to
// Python. Takes the interpreter's lock while it evaluates. What evaluate() raises becomes a
// std::runtime_error, but for what ends a program (KeyboardInterrupt, SystemExit): that leaves as
// it is.
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

// The factor of a Python object, for the object behind the gate. One that is written in Python
// keeps its Python object alive: its class would be gone otherwise.
std::shared_ptr<ceres::CostFunction> ShareFactor(const py::object& factor,
                                                 const std::shared_ptr<CallGate>& gate);
// Null where it is None.
std::shared_ptr<ceres::LossFunction> ShareLoss(const py::object& loss);

}  // namespace highwall::python
