#include <string>

#include <highwall/core/error.h>

#include "bindings.h"
#include "interpreter.h"

namespace highwall::python {
namespace {

constexpr const char* kPybindVersion =
    PYBIND11_TOSTRING(PYBIND11_VERSION_MAJOR) "." PYBIND11_TOSTRING(PYBIND11_VERSION_MINOR);

// pybind11 before 2.12 reads arrays of NumPy 2 with the memory layout of NumPy 1, and crashes.
// Throws py::import_error.
void RequireArraysAreUnderstood() {
  if (PYBIND11_VERSION_HEX >= 0x020C0000) return;
  const std::string numpy = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (std::stoi(numpy) < 2) return;
  throw py::import_error("this module of Highwall was built with pybind11 " +
                         std::string(kPybindVersion) + ", which cannot read arrays of NumPy " +
                         numpy + ": install 'numpy<2', or build it with pybind11 2.12 or newer");
}

}  // namespace
}  // namespace highwall::python

PYBIND11_MODULE(_highwall, module) {
  using namespace highwall::python;
  RequireArraysAreUnderstood();
  EndLocksAtExit();
  module.doc() = "Factor-graph RGB-D-inertial SLAM with points and lines.";
  module.attr("__version__") = HIGHWALL_VERSION;
  module.attr("_pybind11_version") = kPybindVersion;
  py::register_exception<highwall::InvalidArgument>(module, "InvalidArgument", PyExc_ValueError)
      .doc() = "An argument that breaks what its function asks for.";
  py::register_exception<highwall::IoError>(module, "IoError", PyExc_OSError).doc() =
      "A file that is missing, unreadable or malformed.";
  BindGeometry(module);
  BindCostFunction(module);
  BindPriors(module);
  BindVisualFactors(module);
  BindInertialFactors(module);
  BindFactorGraph(module);
  BindSmoother(module);
  BindPoseGraph(module);
  BindTrajectory(module);
  BindUserFactors(module);
  BindPointExtractor(module);
  BindSlam(module);
  BindMapping(module);
}
