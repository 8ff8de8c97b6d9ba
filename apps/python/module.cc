#include <highwall/core/error.h>

#include "bindings.h"

PYBIND11_MODULE(_highwall, module) {
  using namespace highwall::python;
  module.doc() = "Factor-graph RGB-D-inertial SLAM with points and lines.";
  module.attr("__version__") = HIGHWALL_VERSION;
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
  BindOwnFactors(module);
  BindPointExtractor(module);
  BindSlam(module);
  BindMapping(module);
}
