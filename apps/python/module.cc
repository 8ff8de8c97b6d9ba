#include <highwall/core/error.h>

#include "bindings.h"

PYBIND11_MODULE(_highwall, module) {
  using namespace highwall::python;
  module.doc() = "Factor-graph RGB-D-inertial SLAM with points and lines.";
  module.attr("__version__") = HIGHWALL_VERSION;
  py::register_exception<highwall::InvalidArgument>(module, "InvalidArgument", PyExc_ValueError);
  py::register_exception<highwall::IoError>(module, "IoError", PyExc_OSError);
  BindGeometry(module);
  BindCostFunction(module);
  BindPriors(module);
  BindVisualFactors(module);
  BindInertialFactors(module);
  BindFactorGraph(module);
  BindSmoother(module);
  BindPoseGraph(module);
  BindTrajectory(module);
  BindSlam(module);
  BindMapping(module);
}
