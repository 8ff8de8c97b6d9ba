#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <vector>

#include <highwall/core/error.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/factors/white_acceleration.h>
#include <highwall/factors/zero_velocity.h>

#include "bindings.h"
#include "imu_samples.h"

namespace highwall::python {
namespace {

void BindSamples(py::module_& module) {
  py::class_<ImuSample>(module, "ImuSample", "One reading of an IMU, in the body frame.")
      .def(py::init([](Stamp stamp, const Eigen::Vector3d& gyroscope,
                       const Eigen::Vector3d& accelerometer) {
             return ImuSample{stamp, gyroscope, accelerometer};
           }),
           py::arg("stamp"), py::arg("gyroscope"), py::arg("accelerometer"))
      .def_readwrite("stamp", &ImuSample::stamp, "[ns]")
      .def_readwrite("gyroscope", &ImuSample::gyroscope, "[rad/s]")
      .def_readwrite("accelerometer", &ImuSample::accelerometer, "[m/s^2] specific force");
  py::class_<ImuNoise> noise(module, "ImuNoise", "Continuous noise densities of an IMU.");
  KeywordConstructor<ImuNoise>(noise);
  noise.def_readwrite("gyroscope", &ImuNoise::gyroscope, "[rad/s/sqrt(Hz)]")
      .def_readwrite("accelerometer", &ImuNoise::accelerometer, "[m/s^2/sqrt(Hz)]")
      .def_readwrite("gyroscope_walk", &ImuNoise::gyroscope_walk, "[rad/s^2/sqrt(Hz)]")
      .def_readwrite("accelerometer_walk", &ImuNoise::accelerometer_walk, "[m/s^3/sqrt(Hz)]");
}

void BindPreintegration(py::module_& module) {
  py::class_<ImuState>(module, "ImuState", "Pose and velocity of the body.")
      .def(py::init([](const Pose& T_WB, const Eigen::Vector3d& v_WB) {
             return ImuState{T_WB, v_WB};
           }),
           py::arg("T_WB"), py::arg("v_WB"))
      .def_readwrite("T_WB", &ImuState::T_WB)
      .def_readwrite("v_WB", &ImuState::v_WB, "[m/s]");
  py::class_<ImuPreintegration>(module, "ImuPreintegration",
                                "What the readings of an interval say about the motion, whatever "
                                "the state at its start.")
      .def(py::init([](const Stamps& stamps, const Readings& gyroscope,
                       const Readings& accelerometer, const ImuBias& bias, const ImuNoise& noise) {
             return ImuPreintegration(ImuSamples(stamps, gyroscope, accelerometer), bias,
                                      {.noise = noise});
           }),
           py::arg("stamps"), py::arg("gyroscope"), py::arg("accelerometer"),
           py::arg("bias") = ImuBias(ImuBias::Zero()), py::arg("noise") = ImuNoise{},
           "stamps: n, ascending [ns]. gyroscope [rad/s], accelerometer [m/s^2]: n x 3. bias: "
           "[b_g b_a] where it is integrated.")
      .def_property_readonly(
          "duration", [](const ImuPreintegration& imu) { return imu.delta().duration; }, "[s]")
      .def_property_readonly(
          "q_xyzw",
          [](const ImuPreintegration& imu) -> Eigen::Vector4d { return imu.delta().q.coeffs(); },
          "Delta R.")
      .def_property_readonly(
          "v", [](const ImuPreintegration& imu) { return imu.delta().v; }, "Delta v [m/s].")
      .def_property_readonly(
          "p", [](const ImuPreintegration& imu) { return imu.delta().p; }, "Delta p [m].")
      .def_property_readonly(
          "bias_jacobian", [](const ImuPreintegration& imu) { return imu.delta().bias_jacobian; },
          "9 x 6: [theta v p] by [b_g b_a].")
      .def_property_readonly("covariance", &ImuPreintegration::covariance,
                             "15 x 15 of [theta v p b_g b_a].")
      .def("predict", &ImuPreintegration::Predict, py::arg("start"), py::arg("bias"),
           py::arg("gravity_W"), "The state at the end.")
      .def("needs_reintegration", &ImuPreintegration::NeedsReintegration, py::arg("bias"))
      .def("reintegrated", &ImuPreintegration::Reintegrated, py::arg("bias"));
}

}  // namespace

std::vector<ImuSample> ImuSamples(const Stamps& stamps, const Readings& gyroscope,
                                  const Readings& accelerometer) {
  HIGHWALL_REQUIRE(stamps.size() == gyroscope.rows() && stamps.size() == accelerometer.rows(),
                   "stamps, gyroscope and accelerometer have one length");
  std::vector<ImuSample> samples;
  for (Eigen::Index i = 0; i < stamps.size(); ++i) {
    samples.push_back({stamps[i], gyroscope.row(i), accelerometer.row(i)});
  }
  return samples;
}

void BindInertialFactors(py::module_& module) {
  using ceres::CostFunction;
  BindSamples(module);
  BindPreintegration(module);
  module.attr("STANDARD_GRAVITY") = kStandardGravity;
  py::class_<ImuFactor, CostFunction, std::shared_ptr<ImuFactor>>(
      module, "ImuFactor", "Of T_WB, v_WB and bias at both ends: 15 rows [theta v p b_g b_a].")
      .def(py::init<const ImuPreintegration&, const Eigen::Vector3d&, double>(), py::arg("imu"),
           py::arg("gravity_W"), py::arg("weight") = 1.0);
  py::class_<ImuGravityFactor, CostFunction, std::shared_ptr<ImuGravityFactor>>(
      module, "ImuGravityFactor", "As ImuFactor, with the UnitDirection of gravity as the last.")
      .def(py::init<const ImuPreintegration&, double, double>(), py::arg("imu"),
           py::arg("gravity") = kStandardGravity, py::arg("weight") = 1.0);
  py::class_<WhiteAcceleration, CostFunction, std::shared_ptr<WhiteAcceleration>>(
      module, "WhiteAcceleration",
      "Of T_WB_i, [v_WB, w_B] of i, and the same of j: constant velocities, disturbed by white "
      "noise on the accelerations, of densities linear [m^2/s^3] and angular [rad^2/s^3].")
      .def(py::init([](double dt, double linear, double angular) {
             return std::make_shared<WhiteAcceleration>(
                 dt, AccelerationNoise{.linear = linear, .angular = angular});
           }),
           py::arg("dt"), py::arg("linear"), py::arg("angular"));
  py::class_<ZeroVelocity, CostFunction, std::shared_ptr<ZeroVelocity>>(
      module, "ZeroVelocity", "Of v_WB: the body does not move, to sigma [m/s].")
      .def(py::init<double>(), py::arg("sigma") = 0.01);
}

}  // namespace highwall::python
