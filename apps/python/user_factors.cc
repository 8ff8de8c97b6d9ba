#include "user_factors.h"

#include <pybind11/eigen.h>

#include <exception>
#include <memory>
#include <string>
#include <utility>

#include <highwall/factors/position.h>

#include "cost_function.h"
#include "interpreter.h"

namespace highwall::python {
namespace {

// Factor whose exceptions do not reach Ceres' threads, where they would end the program.
class GuardedCost final : public ceres::CostFunction {
 public:
  explicit GuardedCost(std::shared_ptr<ceres::CostFunction> cost) : cost_(std::move(cost)) {
    set_num_residuals(cost_->num_residuals());
    *mutable_parameter_block_sizes() = cost_->parameter_block_sizes();
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    try {
      return cost_->Evaluate(parameters, residuals, jacobians);
    } catch (const std::exception& error) {
      const InterpreterLock lock;
      if (!lock.IsTaken()) return false;
      PyErr_SetString(PyExc_RuntimeError, error.what());
      PyErr_WriteUnraisable(nullptr);
      return false;
    }
  }

 private:
  const std::shared_ptr<ceres::CostFunction> cost_;
};

}  // namespace

void AddFactor(Slam& self, std::vector<Stamp> stamps, const py::object& factor,
               std::optional<int> frame, const py::object& loss, std::string source) {
  std::shared_ptr<ceres::CostFunction> cost = ShareFactor(factor, self.gate());
  // Factors of the library do not throw, and map files identify them by their type.
  if (py::isinstance<PythonFactor>(factor)) cost = std::make_shared<GuardedCost>(std::move(cost));
  PoseFactor added{std::move(stamps), kNoId, std::move(cost), ShareLoss(loss), std::move(source)};
  if (frame) added.frame = ReferenceFrameId(*frame);
  self.Call([&](SlamSystem& slam) { slam.AddFactor(std::move(added)); });
}

void BindUserFactors(py::module_& module) {
  py::class_<PositionFactor, ceres::CostFunction, std::shared_ptr<PositionFactor>>(
      module, "PositionFactor",
      "Of a Pose T_WB and the Pose T_GW of the world in the frame of the measurements: "
      "W (T_GW T_WB lever_arm - p_G), as a GPS measures.")
      .def(py::init<const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Matrix3d&>(),
           py::arg("p_G"), py::arg("lever_arm"), py::arg("sqrt_information"));
  py::class_<FactorCounts>(module, "FactorCounts", "What became of the factors of your own.")
      .def_readonly("waiting", &FactorCounts::waiting, "For a frame at their last stamp.")
      .def_readonly("attached", &FactorCounts::attached, "To keyframes.")
      .def_readonly("refused", &FactorCounts::refused, "No frame with a pose was near enough.")
      .def_readonly("dropped", &FactorCounts::dropped,
                    "Of those attached: all of their stamps ended at one keyframe, which a motion "
                    "within it does not constrain.");
}

}  // namespace highwall::python
