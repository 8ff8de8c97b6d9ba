#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <utility>

#include <highwall/core/sliding_window_smoother.h>

#include "bindings.h"
#include "cost_function.h"
#include "graph_handles.h"

namespace highwall::python {
namespace {

using Smoother = SlidingWindowSmoother;

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

template <class Add>
PythonVariable AddTo(const py::object& object, const Add& add) {
  const Value value = ReadValue(object);
  return {VisitValue(value, [&](const auto& typed) -> VariableId { return add(typed); }),
          value.type};
}

}  // namespace

void BindSmoother(py::module_& module) {
  BindSmootherOptions(module);
  py::class_<Smoother>(module, "SlidingWindowSmoother",
                       "The newest states stay in the window, those before leave behind a prior.")
      .def(py::init<const SlidingWindowOptions&>(), py::arg("options") = SlidingWindowOptions{})
      .def(
          "add_state",
          [](Smoother& smoother, Stamp stamp, const py::object& object) {
            return AddTo(object,
                         [&](const auto& value) { return smoother.AddState(stamp, value); });
          },
          py::arg("stamp"), py::arg("value"), "A variable that leaves with its stamp [ns].")
      .def(
          "add_landmark",
          [](Smoother& smoother, const py::object& object) {
            return AddTo(object, [&](const auto& value) { return smoother.AddLandmark(value); });
          },
          py::arg("value"), "One that leaves once no state of the window observes it.")
      .def(
          "add_calibration",
          [](Smoother& smoother, const py::object& object) {
            return AddTo(object, [&](const auto& value) { return smoother.AddCalibration(value); });
          },
          py::arg("value"), "One that stays.")
      .def(
          "add_factor",
          [](Smoother& smoother, const py::object& factor, const py::args& variables,
             const py::object& loss) {
            const auto ids = Ids(ReadVariables(variables));
            return smoother.AddFactorToBlocks(ShareFactor(factor), ShareLoss(loss), ids);
          },
          py::arg("factor"), py::arg("loss") = py::none(),
          "add_factor(factor, *variables, loss=None)")
      .def(
          "fix", [](Smoother& smoother, const PythonVariable& v) { smoother.Fix(v.id); },
          py::arg("variable"))
      .def(
          "remove", [](Smoother& smoother, const PythonVariable& v) { smoother.Remove(v.id); },
          py::arg("variable"))
      .def("remove_factor", &Smoother::RemoveFactor, py::arg("factor"))
      .def(
          "update", [](Smoother& smoother) { return smoother.Update(); },
          py::call_guard<py::gil_scoped_release>(),
          "Solves, then marginalizes what no longer fits; takes or rejects what was added since "
          "the last call as a whole. Does not throw.")
      .def(
          "value",
          [](const Smoother& smoother, const PythonVariable& v) {
            return MakeValue(v.type, smoother.graph().Block(v.id));
          },
          py::arg("variable"))
      .def(
          "contains",
          [](const Smoother& smoother, const PythonVariable& v) { return smoother.Contains(v.id); },
          py::arg("variable"))
      .def("stamps", &Smoother::Stamps, "Of the states in the window [ns], ascending.")
      .def(
          "covariance",
          [](const Smoother& smoother, const py::args& variables) {
            return smoother.Covariance(Ids(ReadVariables(variables)));
          },
          "covariance(*variables): joint, in their tangent spaces; None where the factors do not "
          "determine them.")
      .def(
          "save",
          [](const Smoother& smoother, const py::object& path) { smoother.Save(Path(path)); },
          py::arg("path"))
      .def_static(
          "load",
          [](const py::object& path, const SlidingWindowOptions& options) {
            return Load(Path(path), options, std::make_integer_sequence<int, kMaxVector>());
          },
          py::arg("path"), py::arg("options") = SlidingWindowOptions{});
}

}  // namespace highwall::python
