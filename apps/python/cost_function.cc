#include "cost_function.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <stdexcept>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/testing/jacobian_check.h>

#include "bindings.h"
#include "interpreter.h"

namespace highwall::python {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<Value> ReadValues(const ceres::CostFunction& factor, const py::args& arguments) {
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  HIGHWALL_REQUIRE(arguments.size() == sizes.size(),
                   "the factor takes " + std::to_string(sizes.size()) + " values, not " +
                       std::to_string(arguments.size()));
  std::vector<Value> values;
  for (const py::handle& argument : arguments) {
    const std::size_t i = values.size();
    values.push_back(ReadValue(argument));
    HIGHWALL_REQUIRE(values[i].type.size == sizes[i],
                     "value " + std::to_string(i) + " of the factor has " +
                         std::to_string(sizes[i]) + " numbers, not " +
                         std::to_string(values[i].type.size));
  }
  return values;
}

// Returns the tangent-space Jacobian of one block from Ceres' ambient Jacobian.
Eigen::MatrixXd TangentJacobian(const Value& value, const RowMajor& ambient) {
  const auto manifold = value.type.MakeManifold();
  if (!manifold) return ambient;
  RowMajor plus(manifold->AmbientSize(), manifold->TangentSize());
  manifold->PlusJacobian(value.block.data(), plus.data());
  return ambient * plus;
}

py::tuple Evaluate(const ceres::CostFunction& factor, const py::args& arguments) {
  const std::vector<Value> values = ReadValues(factor, arguments);
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(factor.num_residuals());
  std::vector<RowMajor> ambient;
  std::vector<const double*> blocks;
  std::vector<double*> jacobians;
  for (const Value& value : values) {
    ambient.emplace_back(RowMajor::Zero(factor.num_residuals(), value.type.size));
    blocks.push_back(value.block.data());
  }
  for (RowMajor& jacobian : ambient) jacobians.push_back(jacobian.data());
  HIGHWALL_REQUIRE(factor.Evaluate(blocks.data(), residuals.data(), jacobians.data()),
                   "the factor cannot be evaluated at these values");
  py::list tangent;
  for (std::size_t i = 0; i < values.size(); ++i) {
    tangent.append(TangentJacobian(values[i], ambient[i]));
  }
  return py::make_tuple(residuals, tangent);
}

testing::JacobianCheckResult Check(const ceres::CostFunction& factor, const py::args& arguments,
                                   double step, double absolute, double relative) {
  std::vector<std::vector<double>> blocks;
  std::vector<std::unique_ptr<ceres::Manifold>> owners;
  std::vector<const ceres::Manifold*> manifolds;
  for (const Value& value : ReadValues(factor, arguments)) {
    blocks.push_back(value.block);
    owners.push_back(value.type.MakeManifold());
    manifolds.push_back(owners.back().get());
  }
  return testing::CheckJacobians(factor, blocks, manifolds,
                                 {.step = step, .absolute = absolute, .relative = relative});
}

// A factor written in Python, used by the object behind a gate.
class CalledFactor final : public ceres::CostFunction {
 public:
  CalledFactor(const py::object& factor, std::shared_ptr<CallGate> gate)
      : gate_(std::move(gate)),
        owner_(gate_->Keep(factor)),
        factor_(*factor.cast<PythonFactor*>()) {
    set_num_residuals(factor_.num_residuals());
    *mutable_parameter_block_sizes() = factor_.parameter_block_sizes();
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const InterpreterLock lock;
    if (!lock.IsTaken()) return false;
    const py::object owner = owner_->Get();
    if (!owner || gate_->interrupted()) return false;
    const CallGate::Work work(*gate_);
    try {
      return factor_.Evaluate(parameters, residuals, jacobians);
    } catch (const py::error_already_set& interrupt) {
      gate_->Interrupt(interrupt);
      return false;
    }
  }

 private:
  const std::shared_ptr<CallGate> gate_;
  const std::shared_ptr<Reference> owner_;
  const PythonFactor& factor_;
};

void BindLosses(py::module_& module) {
  using ceres::LossFunction;
  py::class_<LossFunction, std::shared_ptr<LossFunction>>(
      module, "LossFunction", "A robust loss: rho(s) of the squared norm of a factor's residuals.");
  py::class_<ceres::HuberLoss, LossFunction, std::shared_ptr<ceres::HuberLoss>>(
      module, "HuberLoss", "Linear beyond `delta` sigma.")
      .def(py::init<double>(), py::arg("delta"));
  py::class_<ceres::CauchyLoss, LossFunction, std::shared_ptr<ceres::CauchyLoss>>(
      module, "CauchyLoss", "Logarithmic beyond `delta` sigma.")
      .def(py::init<double>(), py::arg("delta"));
}

}  // namespace

PythonFactor::PythonFactor(int residuals, const std::vector<ValueType>& types) : types_(types) {
  HIGHWALL_REQUIRE(residuals > 0, "a factor has residuals");
  HIGHWALL_REQUIRE(!types.empty(), "a factor has values");
  set_num_residuals(residuals);
  for (const ValueType& type : types) {
    mutable_parameter_block_sizes()->push_back(type.size);
    manifolds_.push_back(type.MakeManifold());
  }
}

bool PythonFactor::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const py::gil_scoped_acquire lock;
  const auto n = num_residuals();
  try {
    const py::function evaluate = py::get_override(this, "evaluate");
    HIGHWALL_REQUIRE(evaluate, "the class of a factor needs a function evaluate(self, *values)");
    py::tuple values(types_.size());
    for (std::size_t i = 0; i < types_.size(); ++i) values[i] = MakeValue(types_[i], parameters[i]);
    const auto [r, J] =
        evaluate(*values).cast<std::pair<Eigen::VectorXd, std::vector<Eigen::MatrixXd>>>();
    HIGHWALL_REQUIRE(r.size() == n && J.size() == types_.size(),
                     "evaluate() returns " + std::to_string(n) + " residuals and " +
                         std::to_string(types_.size()) + " Jacobians");
    Eigen::Map<Eigen::VectorXd>(residuals, n) = r;
    for (std::size_t i = 0; jacobians != nullptr && i < types_.size(); ++i) {
      if (jacobians[i] == nullptr) continue;
      const int tangent = manifolds_[i] ? manifolds_[i]->TangentSize() : types_[i].size;
      HIGHWALL_REQUIRE(J[i].rows() == n && J[i].cols() == tangent,
                       "Jacobian " + std::to_string(i) + " is " + std::to_string(n) + " x " +
                           std::to_string(tangent));
      Eigen::Map<RowMajor> out(jacobians[i], n, types_[i].size);
      if (!manifolds_[i]) {
        out = J[i];
        continue;
      }
      RowMajor lift(tangent, types_[i].size);
      manifolds_[i]->MinusJacobian(parameters[i], lift.data());
      out = J[i] * lift;
    }
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) throw;  // Ctrl-C and the like are not errors of the factor
    throw std::runtime_error(error.what());
  } catch (const py::cast_error&) {
    throw std::runtime_error("evaluate() returns residuals and a list of Jacobians");
  }
  return true;
}

std::shared_ptr<ceres::CostFunction> ShareFactor(const py::object& factor,
                                                 const std::shared_ptr<CallGate>& gate) {
  if (py::isinstance<PythonFactor>(factor)) return std::make_shared<CalledFactor>(factor, gate);
  return factor.cast<std::shared_ptr<ceres::CostFunction>>();
}

std::shared_ptr<ceres::LossFunction> ShareLoss(const py::object& loss) {
  return loss.is_none() ? nullptr : loss.cast<std::shared_ptr<ceres::LossFunction>>();
}

void BindCostFunction(py::module_& module) {
  using ceres::CostFunction;
  py::class_<CostFunction, std::shared_ptr<CostFunction>>(
      module, "CostFunction", "Residuals of some variables: what every factor is.")
      .def_property_readonly("num_residuals", &CostFunction::num_residuals)
      .def("evaluate", &Evaluate,
           "(residuals, [Jacobian of each value]), the Jacobians in the tangent spaces: six "
           "columns for a Pose [dp dtheta]. Throws InvalidArgument where the values do not fit.");
  py::class_<PythonFactor, CostFunction, std::shared_ptr<PythonFactor>>(
      module, "Factor",
      "A factor of your own: derive from it, call Factor.__init__(self, residuals, types) with "
      "the types of its values (Pose, ..., float, or the length of a vector), and define "
      "evaluate(self, *values) -> (residuals, [Jacobian of each value]).")
      .def(py::init([](int residuals, const std::vector<py::object>& types) {
             std::vector<ValueType> read;
             for (const py::object& type : types) read.push_back(ReadValueType(type));
             return std::make_shared<PythonFactor>(residuals, read);
           }),
           py::arg("residuals"), py::arg("types"));
  py::class_<testing::JacobianCheckResult>(module, "JacobianCheckResult",
                                           "True where all Jacobians are right.")
      .def_readonly("ok", &testing::JacobianCheckResult::ok)
      .def_readonly("message", &testing::JacobianCheckResult::message)
      .def("__bool__", [](const testing::JacobianCheckResult& result) { return result.ok; })
      .def("__repr__", [](const testing::JacobianCheckResult& result) {
        return result.ok ? std::string("ok") : result.message;
      });
  module.def("check_jacobians", &Check, py::arg("factor"), py::arg("step") = 1e-6,
             py::arg("absolute") = 1e-7, py::arg("relative") = 1e-6,
             "check_jacobians(factor, *values, step=, absolute=, relative=): compares with central "
             "differences.");
  BindLosses(module);
}

}  // namespace highwall::python
