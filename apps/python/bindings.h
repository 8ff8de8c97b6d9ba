#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <string>
#include <utility>

// The Python module, one component a file. Numbers, vectors and matrices are NumPy arrays of
// doubles, images NumPy arrays as OpenCV's Python module has them, and stamps integers
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
void BindOwnFactors(py::module_& module);
void BindPointExtractor(py::module_& module);
void BindSlam(py::module_& module);
void BindMapping(py::module_& module);

// Options as keyword arguments: Options(field=value, ...). A name that is no field is an
// AttributeError, a value out of range what Validate() throws.
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

// os.PathLike or str.
inline std::filesystem::path Path(const py::object& path) {
  return py::module_::import("os").attr("fspath")(path).template cast<std::string>();
}

}  // namespace highwall::python
