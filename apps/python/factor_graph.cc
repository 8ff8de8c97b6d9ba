#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <memory>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/internal/number_text.h>

#include "bindings.h"
#include "cost_function.h"
#include "exclusive.h"
#include "graph_handles.h"

namespace highwall::python {
namespace {

// Reads a value of the same type as the variable: a Pose is not seven numbers.
Value ValueFor(const PythonVariable& variable, const py::handle& object) {
  Value value = ReadValue(object);
  HIGHWALL_REQUIRE(
      value.type.kind == variable.type.kind && value.type.size == variable.type.size,
      "the variable holds another type than " + py::repr(object.get_type()).cast<std::string>());
  return value;
}

void BindSolver(py::module_& module) {
  py::enum_<LinearSolver>(module, "LinearSolver")
      .value("AUTO", LinearSolver::kAuto)
      .value("DENSE_CHOLESKY", LinearSolver::kDenseCholesky)
      .value("SPARSE_CHOLESKY", LinearSolver::kSparseCholesky)
      .value("DENSE_SCHUR", LinearSolver::kDenseSchur)
      .value("SPARSE_SCHUR", LinearSolver::kSparseSchur)
      .value("COMPACT_SCHUR", LinearSolver::kCompactSchur)
      .value("VARIABLE_PROJECTION", LinearSolver::kVariableProjection);
  py::enum_<SolveStatus>(module, "SolveStatus")
      .value("CONVERGED", SolveStatus::kConverged)
      .value("LIMIT", SolveStatus::kLimit)
      .value("STOPPED", SolveStatus::kStopped)
      .value("FAILED", SolveStatus::kFailed);
  py::class_<SolveOptions> options(module, "SolveOptions",
                                   "Levenberg-Marquardt; the stopping rules are those of Ceres, "
                                   "and one of COMPACT_SCHUR and VARIABLE_PROJECTION.");
  KeywordConstructor<SolveOptions>(options);
  options.def_readwrite("max_iterations", &SolveOptions::max_iterations)
      .def_readwrite("threads", &SolveOptions::threads)
      .def_readwrite("max_seconds", &SolveOptions::max_seconds, "[s]")
      .def_readwrite("function_tolerance", &SolveOptions::function_tolerance)
      .def_readwrite("gradient_tolerance", &SolveOptions::gradient_tolerance)
      .def_readwrite("parameter_tolerance", &SolveOptions::parameter_tolerance)
      .def_readwrite("initial_trust_region_radius", &SolveOptions::initial_trust_region_radius)
      .def_readwrite("linear_solver", &SolveOptions::linear_solver);
  py::class_<SolveSummary>(module, "SolveSummary", "What became of a solve.")
      .def_readonly("status", &SolveSummary::status)
      .def_readonly("message", &SolveSummary::message)
      .def_readonly("initial_cost", &SolveSummary::initial_cost)
      .def_readonly("final_cost", &SolveSummary::final_cost)
      .def_readonly("iterations", &SolveSummary::iterations)
      .def_readonly("seconds", &SolveSummary::seconds)
      .def("is_usable", &SolveSummary::IsUsable)
      .def("__repr__", [](const SolveSummary& summary) {
        return std::string("SolveSummary(") + ToString(summary.status) + ", cost " +
               FixedText(summary.initial_cost) + " -> " + FixedText(summary.final_cost) + ")";
      });
}

void BindHandles(py::module_& module) {
  py::class_<PythonVariable>(module, "Variable", "Names a variable of one graph.")
      .def("__eq__", [](const PythonVariable& a, const PythonVariable& b) { return a.id == b.id; })
      .def("__hash__", [](const PythonVariable& variable) {
        return py::hash(
            py::make_tuple(variable.id.index, variable.id.generation, variable.id.graph));
      });
  py::class_<FactorId>(module, "FactorId", "Names a factor of one graph.")
      .def("__eq__", [](const FactorId& a, const FactorId& b) { return a == b; })
      .def("__hash__", [](const FactorId& id) {
        return py::hash(py::make_tuple(id.index, id.generation, id.graph));
      });
}

}  // namespace

std::vector<VariableId> Ids(const std::vector<PythonVariable>& variables) {
  std::vector<VariableId> ids;
  for (const PythonVariable& variable : variables) ids.push_back(variable.id);
  return ids;
}

std::vector<PythonVariable> ReadVariables(const py::args& variables) {
  return py::cast<std::vector<PythonVariable>>(variables);
}

void BindFactorGraph(py::module_& module) {
  BindSolver(module);
  BindHandles(module);
  using Graph = Exclusive<FactorGraph>;
  const auto add = [](Graph& self, const py::object& object, bool landmark) {
    const Value value = ReadValue(object);
    const VariableId id = self.Call([&](FactorGraph& graph) {
      return VisitValue(value, [&](const auto& typed) -> VariableId {
        return landmark ? graph.AddLandmark(typed) : graph.AddVariable(typed);
      });
    });
    return PythonVariable{id, value.type};
  };
  // Binds a member function that takes a variable.
  const auto of_variable = []<class Result>(Result (FactorGraph::*function)(const VariableId&)) {
    return [function](Graph& self, const PythonVariable& variable) {
      return self.Call([&](FactorGraph& graph) { return (graph.*function)(variable.id); });
    };
  };
  py::class_<Graph>(module, "FactorGraph",
                    "Variables and factors: minimizes the sum of rho(|r|^2) / 2. Functions "
                    "throw InvalidArgument for a handle that is not of this graph.",
                    Collected<Graph>())
      .def(py::init([] {
        return std::make_unique<Graph>("FactorGraph", [](const auto&) { return FactorGraph(); });
      }))
      .def(
          "add_variable",
          [add](Graph& self, const py::object& value) { return add(self, value, false); },
          py::arg("value"),
          "A Pose, OrthonormalLine, Segment3, UnitDirection, number or vector. Returns a handle.")
      .def(
          "add_landmark",
          [add](Graph& self, const py::object& value) { return add(self, value, true); },
          py::arg("value"), "One that is eliminated first; no factor may join two.")
      .def(
          "add_factor",
          [](Graph& self, const py::object& factor, const py::args& variables,
             const py::object& loss) {
            const auto ids = Ids(ReadVariables(variables));
            auto cost = ShareFactor(factor, self.gate());
            auto robust = ShareLoss(loss);
            return self.Call([&](FactorGraph& graph) {
              return graph.AddFactorToBlocks(std::move(cost), std::move(robust), ids);
            });
          },
          py::arg("factor"), py::arg("loss") = py::none(),
          "add_factor(factor, *variables, loss=None)")
      .def(
          "value",
          [](Graph& self, const PythonVariable& variable) {
            const auto block = self.Call([&](const FactorGraph& graph) {
              const double* values = graph.Block(variable.id);
              return std::vector<double>(values, values + variable.type.size);
            });
            return MakeValue(variable.type, block.data());
          },
          py::arg("variable"))
      .def(
          "set_value",
          [](Graph& self, const PythonVariable& variable, const py::object& object) {
            const Value read = ValueFor(variable, object);
            self.Call([&](FactorGraph& graph) {
              VisitValue(read, [&]<class T>(const T& value) {
                graph.SetValue(Variable<T>{variable.id}, value);
                return true;
              });
            });
          },
          py::arg("variable"), py::arg("value"))
      .def("fix", of_variable(&FactorGraph::Fix), py::arg("variable"),
           "It keeps its value in solve().")
      .def("unfix", of_variable(&FactorGraph::Unfix), py::arg("variable"))
      .def(
          "is_fixed",
          [](Graph& self, const PythonVariable& v) {
            return self.Call([&](const FactorGraph& graph) { return graph.IsFixed(v.id); });
          },
          py::arg("variable"))
      .def("remove", of_variable(&FactorGraph::Remove), py::arg("variable"),
           "With every factor that touches it.")
      .def("remove_factor", Exclusively<FactorGraph>(&FactorGraph::RemoveFactor), py::arg("factor"))
      .def_property_readonly("num_variables", Exclusively<FactorGraph>(&FactorGraph::NumVariables))
      .def_property_readonly("num_factors", Exclusively<FactorGraph>(&FactorGraph::NumFactors))
      .def("fault_of", Exclusively<FactorGraph>(&FactorGraph::FaultOf), py::arg("factor"),
           "Why it cannot be evaluated at the present values; empty if it can.")
      .def("squared_error", Exclusively<FactorGraph>(&FactorGraph::SquaredError), py::arg("factor"),
           "|r|^2 at the present values, without its loss.")
      .def("cost", Exclusively<FactorGraph>(&FactorGraph::Cost),
           "Sum over factors of rho(|r|^2) / 2.")
      .def(
          "solve",
          [](Graph& self, const SolveOptions& options) {
            return self.Call([&](FactorGraph& graph) {
              return graph.Solve(Interruptible(options, *self.gate()));
            });
          },
          py::arg("options") = SolveOptions{},
          "Improves the values of the variables that are not fixed. Ctrl-C ends it after the "
          "running iteration.")
      .def(
          "covariance",
          [](Graph& self, const py::args& variables) {
            const auto ids = Ids(ReadVariables(variables));
            return self.Call([&](const FactorGraph& graph) { return graph.Covariance(ids); });
          },
          "covariance(*variables): joint, in their tangent spaces; None where the factors do not "
          "determine them or cannot be evaluated: undetermined() says why.")
      .def(
          "undetermined", Exclusively<FactorGraph>(&FactorGraph::Undetermined),
          "A factor that cannot be evaluated, or a variable that the factors do not determine, and "
          "what to do; empty if they determine all.");
}

}  // namespace highwall::python
