#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <highwall/core/error.h>
#include <highwall/factors/camera_pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/extrinsic_factor.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_in_frame.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/factors/scaled_motion.h>
#include <highwall/factors/time_offset_factor.h>

#include "bindings.h"
#include "cost_function.h"

namespace highwall::python {
namespace {

using ceres::CostFunction;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

template <class Factor>
auto FactorClass(py::module_& module, const char* name, const char* documentation) {
  return py::class_<Factor, CostFunction, std::shared_ptr<Factor>>(module, name, documentation);
}

// The factor that a factor of Highwall wraps. One written in Python needs its object, which C++
// does not keep alive there.
std::shared_ptr<const CostFunction> Wrapped(const std::shared_ptr<CostFunction>& seen) {
  HIGHWALL_REQUIRE(!std::dynamic_pointer_cast<PythonFactor>(seen),
                   "a factor written in Python cannot be wrapped: give it the variable itself");
  return seen;
}

void BindNoise(py::module_& module) {
  py::enum_<Weighting>(module, "Weighting", "How rows that carry depth are whitened.")
      .value("COVARIANCE", Weighting::kCovariance)
      .value("PAPER", Weighting::kPaper);
  py::class_<DepthNoise> noise(module, "DepthNoise",
                               "sigma(d) = offset + quadratic (d - reference)^2 [m].");
  KeywordConstructor<DepthNoise>(noise);
  noise.def_readwrite("offset", &DepthNoise::offset, "[m]")
      .def_readwrite("quadratic", &DepthNoise::quadratic, "[1/m]")
      .def_readwrite("reference", &DepthNoise::reference, "[m]")
      .def_static("kinect", &DepthNoise::Kinect)
      .def_static("stereo", &DepthNoise::Stereo, py::arg("subpixel") = 0.08,
                  py::arg("focal") = 425.0, py::arg("baseline") = 0.05)
      .def("sigma", &DepthNoise::Sigma, py::arg("d"), "[m] at depth d [m]")
      .def("disparity_sigma", &DepthNoise::DisparitySigma, py::arg("d"), py::arg("right"), "[px]");
  module.def("point_sqrt_information", &PointSqrtInformation, py::arg("weighting"),
             py::arg("sigma_px"), py::arg("sigma_disparity"), "W of a row (u, v, disparity).");
  py::class_<RgbdProjection>(module, "RgbdProjection",
                             "The RGB-D camera of a body: camera without distortion, T_BC.")
      .def(py::init([](const PinholeCamera& camera, const Pose& T_BC, double baseline) {
             return RgbdProjection(camera, T_BC, {.fx = camera.fx, .baseline = baseline});
           }),
           py::arg("camera"), py::arg("T_BC") = Pose(), py::arg("baseline") = 0.08)
      .def("project", &RgbdProjection::Project, py::arg("p_C"),
           "(u, v, disparity) [px] of a point [m] with z > 0, which is not checked.");
}

void BindPoints(py::module_& module) {
  FactorClass<PointInFrame>(module, "PointInFrame",
                            "Of a Pose T_WF and a point p_W: W (T_WF^-1 p_W - p_F), 3 rows.")
      .def(py::init<const Eigen::Vector3d&, const Eigen::Matrix3d&>(), py::arg("p_F"),
           py::arg("sqrt_information"));
  FactorClass<PointReprojection>(module, "PointReprojection",
                                 "Of a Pose T_WB and a point p_W: W ((u, v) - z), 2 rows.")
      .def(py::init<const Eigen::Vector2d&, const Eigen::Matrix2d&, const RgbdProjection&>(),
           py::arg("uv"), py::arg("sqrt_information"), py::arg("projection"));
  FactorClass<PointReprojectionRgbd>(module, "PointReprojectionRgbd",
                                     "The same with disparity, 3 rows.")
      .def(py::init<const Eigen::Vector3d&, const Eigen::Matrix3d&, const RgbdProjection&>(),
           py::arg("uvd"), py::arg("sqrt_information"), py::arg("projection"));
}

void BindLineFactors(py::module_& module) {
  FactorClass<LineReprojection>(module, "LineReprojection",
                                "Of T_WB and a Segment3: distances of its ends to the line through "
                                "s and e [px], 2 rows.")
      .def(py::init([](const Eigen::Vector2d& s, const Eigen::Vector2d& e, double sigma_px,
                       const RgbdProjection& projection) {
             return std::make_shared<LineReprojection>(SegmentRows(s, e, sigma_px), projection);
           }),
           py::arg("s"), py::arg("e"), py::arg("sigma_px"), py::arg("projection"));
  FactorClass<LineReprojectionRgbd>(module, "LineReprojectionRgbd",
                                    "The same with depth; s and e are (u, v, disparity), 4 rows.")
      .def(py::init([](const Eigen::Vector3d& s, const Eigen::Vector3d& e,
                       const RgbdProjection& projection, const SegmentNoise& noise,
                       Weighting weighting) {
             return std::make_shared<LineReprojectionRgbd>(SegmentRows({s, e}, noise, weighting),
                                                           projection);
           }),
           py::arg("s"), py::arg("e"), py::arg("projection"), py::arg("noise") = SegmentNoise{},
           py::arg("weighting") = Weighting::kCovariance);
  FactorClass<OrthonormalLineReprojection>(module, "OrthonormalLineReprojection",
                                           "Of T_WB and an OrthonormalLine, 2 rows.")
      .def(
          py::init<const Eigen::Vector2d&, const Eigen::Vector2d&, double, const RgbdProjection&>(),
          py::arg("s"), py::arg("e"), py::arg("sigma_px"), py::arg("projection"));
  FactorClass<OrthonormalLineReprojectionRgbd>(module, "OrthonormalLineReprojectionRgbd",
                                               "Of T_WB and an OrthonormalLine, 4 rows.")
      .def(py::init([](const Eigen::Vector3d& s, const Eigen::Vector3d& e,
                       const RgbdProjection& projection, const SegmentNoise& noise,
                       Weighting weighting) {
             return std::make_shared<OrthonormalLineReprojectionRgbd>(RgbdSegment{s, e}, noise,
                                                                      weighting, projection);
           }),
           py::arg("s"), py::arg("e"), py::arg("projection"), py::arg("noise") = SegmentNoise{},
           py::arg("weighting") = Weighting::kCovariance);
}

void BindCalibration(py::module_& module) {
  FactorClass<ExtrinsicFactor>(module, "ExtrinsicFactor",
                               "Of the values of `seen`, a factor on the pose of a camera that is "
                               "its own body, with T_WB in its place, and last T_BC.")
      .def(py::init([](const std::shared_ptr<CostFunction>& seen) {
             return std::make_shared<ExtrinsicFactor>(Wrapped(seen));
           }),
           py::arg("seen"));
  FactorClass<TimeOffsetFactor>(module, "TimeOffsetFactor",
                                "Of the values of `seen`, a factor on T_WB, and last the time "
                                "offset t_d [s], by which the body moves on.")
      .def(py::init([](const std::shared_ptr<CostFunction>& seen, const Eigen::Vector3d& v_WB,
                       const Eigen::Vector3d& omega_B, double t_d_state) {
             return std::make_shared<TimeOffsetFactor>(Wrapped(seen), v_WB, omega_B, t_d_state);
           }),
           py::arg("seen"), py::arg("v_WB"), py::arg("omega_B"), py::arg("t_d_state") = 0.0);
}

void BindPoses(py::module_& module) {
  FactorClass<CameraPose>(module, "CameraPose",
                          "Of T_WB, v_WB and t_d: an image's pose as a Gaussian, 6 rows.")
      .def(py::init<const Pose&, const Matrix6&, const Pose&, const Eigen::Vector3d&, double>(),
           py::arg("T_WC_0"), py::arg("sqrt_information"), py::arg("T_BC"), py::arg("omega_B"),
           py::arg("t_d_state") = 0.0);
  FactorClass<ExtrinsicCameraPose>(module, "ExtrinsicCameraPose",
                                   "Of T_WB, v_WB, t_d, T_BC and the scale of the depth, 6 rows.")
      .def(py::init<const Pose&, const Matrix6&, const Eigen::Vector3d&, double>(),
           py::arg("T_WC_0"), py::arg("sqrt_information"), py::arg("omega_B"),
           py::arg("t_d_state") = 0.0);
  FactorClass<ScaledMotion>(module, "ScaledMotion",
                            "Of T_WB_i, T_WB_j and the scale of the depth, 6 rows.")
      .def(py::init<const Pose&, const Matrix6&, const Pose&>(), py::arg("Z"),
           py::arg("sqrt_information"), py::arg("T_BC") = Pose());
  FactorClass<PointToPlane>(module, "PointToPlane",
                            "Of T_WR, which saw the plane (normal n, point a), and T_WB, which saw "
                            "the point p: their distance, 1 row.")
      .def(py::init([](const Eigen::Vector3d& n, const Eigen::Vector3d& a, const Eigen::Vector3d& p,
                       double sigma) {
             return std::make_shared<PointToPlane>(
                 PointToPlaneRow{.n = n, .a = a, .p = p, .inverse_sigma = 1.0 / sigma});
           }),
           py::arg("n"), py::arg("a"), py::arg("p"), py::arg("sigma"));
}

}  // namespace

void BindVisualFactors(py::module_& module) {
  BindNoise(module);
  py::class_<SegmentNoise> noise(module, "SegmentNoise",
                                 "Standard deviations of an observed segment [px].");
  KeywordConstructor<SegmentNoise>(noise);
  noise.def_readwrite("px", &SegmentNoise::px)
      .def_readwrite("disparity_s", &SegmentNoise::disparity_s)
      .def_readwrite("disparity_e", &SegmentNoise::disparity_e);
  BindPoints(module);
  BindLineFactors(module);
  BindCalibration(module);
  BindPoses(module);
}

}  // namespace highwall::python
