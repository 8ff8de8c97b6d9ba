#include <pybind11/eigen.h>

#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

#include "bindings.h"

namespace highwall::python {
namespace {

template <int N>
void BindVectorPrior(py::module_& module) {
  using Prior = VectorPrior<N>;
  py::class_<Prior, ceres::CostFunction, std::shared_ptr<Prior>>(
      module, ("VectorPrior" + std::to_string(N)).c_str(), "W (x - x_0) of a vector or a number.")
      .def(py::init<const typename Prior::Vector&, const typename Prior::Matrix&>(), py::arg("x_0"),
           py::arg("sqrt_information"));
}

}  // namespace

void BindPriors(py::module_& module) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using ceres::CostFunction;
  py::class_<PosePrior, CostFunction, std::shared_ptr<PosePrior>>(
      module, "PosePrior", "Of a Pose: W [p - p_0 | Log(q_0^-1 q)].")
      .def(py::init<const Pose&, const Matrix6&>(), py::arg("T_0"), py::arg("sqrt_information"));
  py::class_<DirectionPrior, CostFunction, std::shared_ptr<DirectionPrior>>(
      module, "DirectionPrior", "Of a UnitDirection, with a standard deviation [rad].")
      .def(py::init<const UnitDirection&, double>(), py::arg("n_0"), py::arg("sigma"));
  py::class_<GravityPrior, CostFunction, std::shared_ptr<GravityPrior>>(
      module, "GravityPrior",
      "Of a Pose of one frame in another: both have their z axis up, to a standard deviation "
      "[rad].")
      .def(py::init<double>(), py::arg("sigma"));
  BindVectorPrior<1>(module);
  BindVectorPrior<2>(module);
  BindVectorPrior<3>(module);
  BindVectorPrior<6>(module);
  py::class_<RelativePose, CostFunction, std::shared_ptr<RelativePose>>(
      module, "RelativePose", "Of two Poses: W Log(Z^-1 T_i^-1 T_j) of SE(3), [rho | theta].")
      .def(py::init<const Pose&, const Matrix6&>(), py::arg("Z"), py::arg("sqrt_information"));
}

}  // namespace highwall::python
