#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <utility>
#include <vector>

#include <highwall/core/sliding_window_smoother.h>

#include "bindings.h"
#include "cost_function.h"
#include "exclusive.h"
#include "graph_handles.h"

namespace highwall::python {
namespace {

using Smoother = SlidingWindowSmoother;

constexpr const char* kSmootherName = "SlidingWindowSmoother";

SlidingWindowOptions Interruptible(SlidingWindowOptions options, CallGate& gate) {
  options.solve = python::Interruptible(options.solve, gate);
  return options;
}

template <int... kIndex>
Smoother Load(const std::filesystem::path& path, const SlidingWindowOptions& options,
              std::integer_sequence<int, kIndex...>) {
  return Smoother::Load<Pose, OrthonormalLine, Segment3, UnitDirection, double,
                        Eigen::Matrix<double, kIndex + 1, 1>...>(path, options);
}

void BindSmootherOptions(py::module_& module) {
  py::enum_<LeavingPolicy>(module, "LeavingPolicy")
      .value("OLDEST_FIRST", LeavingPolicy::kOldestFirst)
      .value("LEAST_INFORMATION", LeavingPolicy::kLeastInformation);
  py::enum_<LandmarkPolicy>(module, "LandmarkPolicy")
      .value("KEEP_TRACKED", LandmarkPolicy::kKeepTracked)
      .value("MARGINALIZE", LandmarkPolicy::kMarginalize);
  py::class_<SlidingWindowOptions> options(module, "SlidingWindowOptions",
                                           "Of a SlidingWindowSmoother.");
  KeywordConstructor<SlidingWindowOptions>(options);
  options.def_readwrite("max_states", &SlidingWindowOptions::max_states)
      .def_readwrite("max_seconds", &SlidingWindowOptions::max_seconds, "[s]")
      .def_readwrite("budget_ms", &SlidingWindowOptions::budget_ms, "[ms] of an update")
      .def_readwrite("leaving", &SlidingWindowOptions::leaving)
      .def_readwrite("protected_states", &SlidingWindowOptions::protected_states)
      .def_readwrite("landmarks", &SlidingWindowOptions::landmarks)
      .def_readwrite("max_error", &SlidingWindowOptions::max_error)
      .def_readwrite("solve", &SlidingWindowOptions::solve);
  py::class_<UpdateReport>(module, "UpdateReport", "What became of an update.")
      .def_readonly("accepted", &UpdateReport::accepted)
      .def_readonly("message", &UpdateReport::message)
      .def_readonly("solve", &UpdateReport::solve)
      .def_readonly("left", &UpdateReport::left, "Stamps of the states that left.")
      .def_readonly("dropped_factors", &UpdateReport::dropped_factors)
      .def_readonly("seconds", &UpdateReport::seconds);
}

// Calls add(smoother, value as the C++ type) and returns its handle.
template <class Add>
PythonVariable AddTo(Exclusive<Smoother>& self, const py::object& object, const Add& add) {
  const Value value = ReadValue(object);
  const VariableId id = self.Call([&](Smoother& smoother) {
    return VisitValue(value, [&](const auto& typed) -> VariableId { return add(smoother, typed); });
  });
  return {id, value.type};
}

}  // namespace

void BindSmoother(py::module_& module) {
  BindSmootherOptions(module);
  using Window = Exclusive<Smoother>;
  py::class_<Window>(module, kSmootherName,
                     "The newest states stay in the window, those before leave behind a prior.",
                     Collected<Window>())
      .def(py::init([](const SlidingWindowOptions& options) {
             return std::make_unique<Window>(kSmootherName, [&](const auto& gate) {
               return Smoother(Interruptible(options, *gate));
             });
           }),
           py::arg("options") = SlidingWindowOptions{})
      .def(
          "add_state",
          [](Window& self, Stamp stamp, const py::object& object) {
            return AddTo(self, object, [stamp](Smoother& smoother, const auto& value) {
              return smoother.AddState(stamp, value);
            });
          },
          py::arg("stamp"), py::arg("value"), "A variable that leaves with its stamp [ns].")
      .def(
          "add_landmark",
          [](Window& self, const py::object& object) {
            return AddTo(self, object, [](Smoother& smoother, const auto& value) {
              return smoother.AddLandmark(value);
            });
          },
          py::arg("value"), "One that leaves once no state of the window observes it.")
      .def(
          "add_calibration",
          [](Window& self, const py::object& object) {
            return AddTo(self, object, [](Smoother& smoother, const auto& value) {
              return smoother.AddCalibration(value);
            });
          },
          py::arg("value"), "One that stays.")
      .def(
          "add_factor",
          [](Window& self, const py::object& factor, const py::args& variables,
             const py::object& loss) {
            const auto ids = Ids(ReadVariables(variables));
            auto cost = ShareFactor(factor, self.gate());
            auto robust = ShareLoss(loss);
            return self.Call([&](Smoother& smoother) {
              return smoother.AddFactorToBlocks(std::move(cost), std::move(robust), ids);
            });
          },
          py::arg("factor"), py::arg("loss") = py::none(),
          "add_factor(factor, *variables, loss=None)")
      .def(
          "fix",
          [](Window& self, const PythonVariable& v) {
            self.Call([&](Smoother& smoother) { smoother.Fix(v.id); });
          },
          py::arg("variable"))
      .def(
          "remove",
          [](Window& self, const PythonVariable& v) {
            self.Call([&](Smoother& smoother) { smoother.Remove(v.id); });
          },
          py::arg("variable"))
      .def("remove_factor", Exclusively<Smoother>(&Smoother::RemoveFactor), py::arg("factor"))
      .def(
          "update",
          [](Window& self) {
            return self.Call([](Smoother& smoother) { return smoother.Update(); });
          },
          "Solves, then marginalizes the states that leave the window; accepts or rejects the "
          "additions since the last call as a whole. Does not throw.")
      .def(
          "value",
          [](Window& self, const PythonVariable& v) {
            const auto block = self.Call([&](const Smoother& smoother) {
              const double* values = smoother.graph().Block(v.id);
              return std::vector<double>(values, values + v.type.size);
            });
            return MakeValue(v.type, block.data());
          },
          py::arg("variable"))
      .def(
          "contains",
          [](Window& self, const PythonVariable& v) {
            return self.Call([&](const Smoother& smoother) { return smoother.Contains(v.id); });
          },
          py::arg("variable"))
      .def("stamps", Exclusively<Smoother>(&Smoother::Stamps),
           "Of the states in the window [ns], ascending.")
      .def(
          "covariance",
          [](Window& self, const py::args& variables) {
            const auto ids = Ids(ReadVariables(variables));
            return self.Call([&](const Smoother& smoother) { return smoother.Covariance(ids); });
          },
          "covariance(*variables): joint, in their tangent spaces; None where the factors do not "
          "determine them.")
      .def(
          "save",
          [](Window& self, const py::object& object) {
            const std::filesystem::path path = Path(object);
            self.Call([&](const Smoother& smoother) { smoother.Save(path); });
          },
          py::arg("path"))
      .def_static(
          "load",
          [](const py::object& path, const SlidingWindowOptions& options) {
            return std::make_unique<Window>(kSmootherName, [&](const auto& gate) {
              return Load(Path(path), Interruptible(options, *gate),
                          std::make_integer_sequence<int, kMaxVector>());
            });
          },
          py::arg("path"), py::arg("options") = SlidingWindowOptions{});
}

}  // namespace highwall::python
