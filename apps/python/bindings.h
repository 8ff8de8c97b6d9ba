#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <string>
#include <utility>

// The Python module, one component per file. Numbers, vectors and matrices are NumPy arrays of
// doubles, images are NumPy arrays as in OpenCV's Python module, and stamps are integers
// (nanoseconds), as everywhere in Highwall.
namespace highwall::python {

namespace py = pybind11;

void BindGeometry(py::module_& module);
void BindCostFunction(py::module_& module);
void BindPriors(py::module_& module);
void BindVisualFactors(py::module_& module);
void BindInertialFactors(py::module_& module);
void BindFactorGraph(py::module_& module);
void BindSmoother(py::module_& module);
void BindPoseGraph(py::module_& module);
void BindTrajectory(py::module_& module);
void BindUserFactors(py::module_& module);
void BindPointExtractor(py::module_& module);
void BindSlam(py::module_& module);
void BindMapping(py::module_& module);

// Defines a constructor with keyword arguments: Options(field=value, ...). An unknown name raises
// an AttributeError, a value out of range the error of Validate().
template <class Options, class Class>
void KeywordConstructor(Class& options_class) {
  options_class.def(py::init([](const py::kwargs& fields) {
    const py::object options = py::cast(Options{});
    for (const auto& [name, value] : fields) py::setattr(options, name, value);
    const Options result = options.template cast<Options>();
    if constexpr (requires { result.Validate(); }) result.Validate();
    return result;
  }));
}

// Converts an os.PathLike or str.
inline std::filesystem::path Path(const py::object& path) {
  return py::module_::import("os").attr("fspath")(path).template cast<std::string>();
}

}  // namespace highwall::python
