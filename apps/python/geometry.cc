#include <pybind11/eigen.h>
#include <pybind11/operators.h>
#include <pybind11/stl.h>

#include <highwall/core/camera.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/so3.h>
#include <highwall/core/sqrt_information.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/number_text.h>

#include "bindings.h"

namespace highwall::python {
namespace {

using Matrix3X = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Eigen::Quaterniond Quaternion(const Eigen::Vector4d& xyzw) {
  return Eigen::Quaterniond(xyzw.w(), xyzw.x(), xyzw.y(), xyzw.z());
}

std::string Repr(const Pose& pose) {
  TextWriter text;
  text << "Pose(p=[" << pose.p().transpose() << "], q_xyzw=[" << pose.q().coeffs().transpose()
       << "])";
  return text.str();
}

void BindPose(py::module_& module) {
  py::class_<Pose>(module, "Pose",
                   "A rigid transform T_AB, p_A = R_AB p_B + p_AB: the pose of frame B in frame A. "
                   "Metres and a unit Hamilton quaternion. T_AC = T_AB * T_BC.")
      .def(py::init<>(), "The identity.")
      .def(py::init([](const Eigen::Vector3d& p, const Eigen::Vector4d& q_xyzw) {
             return Pose(Quaternion(q_xyzw), p);
           }),
           py::arg("p"), py::arg("q_xyzw"), "Position [m] and quaternion, which is normalised.")
      .def_static("from_matrix", &Pose::FromMatrix, py::arg("T"),
                  "Of a rigid 4 x 4 matrix. Throws InvalidArgument if it is none (to 1e-3).")
      .def_static("from_tangent", &Pose::FromTangent, py::arg("p"), py::arg("theta"),
                  "Position [m] and rotation vector [rad].")
      .def_property_readonly("p", &Pose::p, "Position [m].")
      .def_property_readonly(
          "q_xyzw", [](const Pose& pose) -> Eigen::Vector4d { return pose.q().coeffs(); },
          "Unit quaternion, in the order of a TUM file.")
      .def_property_readonly("R", &Pose::R, "Rotation matrix, 3 x 3.")
      .def("matrix", &Pose::Matrix, "4 x 4.")
      .def("inverse", &Pose::Inverse, "T_BA.")
      .def(py::self * py::self)
      .def(
          "__mul__",
          [](const Pose& T, const Eigen::Vector3d& p) -> Eigen::Vector3d { return T * p; },
          py::is_operator(), "p_A of p_B [m].")
      .def(
          "transform",
          [](const Pose& T, const Matrix3X& p) -> Matrix3X {
            return (p * T.R().transpose()).rowwise() + T.p().transpose();
          },
          py::arg("points"), "Points [m], n x 3, moved from B to A.")
      .def("plus", &Pose::Plus, py::arg("d"), "p + d[:3], R Exp(d[3:]) [m, rad].")
      .def("angle", &Pose::Angle, "Of the rotation [rad], in [0, pi].")
      .def("__repr__", &Repr);
}

void BindLines(py::module_& module) {
  py::class_<PluckerLine>(module, "PluckerLine",
                          "A line: moment n = p x d of every point p on it, and direction d.")
      .def(py::init<>())
      .def_static("from_points", &PluckerLine::FromPoints, py::arg("p"), py::arg("q"),
                  "Through two points [m]. Throws InvalidArgument if they coincide.")
      .def_readwrite("n", &PluckerLine::n, "Moment.")
      .def_readwrite("d", &PluckerLine::d, "Direction.")
      .def("closest_to_origin", &PluckerLine::ClosestToOrigin)
      .def("distance", &PluckerLine::Distance, py::arg("x"), "[m]")
      .def("project", &PluckerLine::Project, py::arg("x"), "Foot of the perpendicular from x.");
  py::class_<OrthonormalLine>(module, "OrthonormalLine",
                              "A line with four degrees of freedom, a variable of a graph.")
      .def(py::init<>())
      .def(py::init<const PluckerLine&>(), py::arg("line"))
      .def("plucker", &OrthonormalLine::Plucker);
  py::class_<Segment3>(module, "Segment3", "Two end points [m], a variable of a graph.")
      .def(py::init<const Eigen::Vector3d&, const Eigen::Vector3d&>(), py::arg("p"), py::arg("q"))
      .def_property_readonly("p", &Segment3::p)
      .def_property_readonly("q", &Segment3::q)
      .def("length", &Segment3::Length, "[m]");
  py::class_<UnitDirection>(module, "UnitDirection", "A unit vector, a variable of a graph.")
      .def(py::init<>(), "(0, 0, -1): gravity's, unless estimated.")
      .def(py::init<const Eigen::Vector3d&>(), py::arg("v"))
      .def_property_readonly("vector", &UnitDirection::vector);
}

void BindCameras(py::module_& module) {
  py::enum_<LensModel>(module, "LensModel", "How a lens bends rays.")
      .value("RADIAL_TANGENTIAL", LensModel::kRadialTangential)
      .value("EQUIDISTANT", LensModel::kEquidistant);
  py::class_<PinholeCamera> camera(
      module, "PinholeCamera",
      "A pinhole with the distortion of a lens: radial-tangential with k1, k2, p1, p2, k3 and, of "
      "OpenCV's rational model, k4 to k6; or equidistant (fisheye) with k1 to k4. Pixel centres "
      "have integer coordinates; x right, y down, z forward.");
  KeywordConstructor<PinholeCamera>(camera);
  camera.def_readwrite("width", &PinholeCamera::width, "[px]")
      .def_readwrite("height", &PinholeCamera::height, "[px]")
      .def_readwrite("fx", &PinholeCamera::fx, "[px]")
      .def_readwrite("fy", &PinholeCamera::fy, "[px]")
      .def_readwrite("cx", &PinholeCamera::cx, "[px]")
      .def_readwrite("cy", &PinholeCamera::cy, "[px]")
      .def_readwrite("k1", &PinholeCamera::k1)
      .def_readwrite("k2", &PinholeCamera::k2)
      .def_readwrite("p1", &PinholeCamera::p1)
      .def_readwrite("p2", &PinholeCamera::p2)
      .def_readwrite("k3", &PinholeCamera::k3)
      .def_readwrite("k4", &PinholeCamera::k4)
      .def_readwrite("k5", &PinholeCamera::k5)
      .def_readwrite("k6", &PinholeCamera::k6)
      .def_readwrite("lens", &PinholeCamera::lens)
      .def("without_distortion", &PinholeCamera::WithoutDistortion)
      .def(
          "project",
          [](const PinholeCamera& self, const Eigen::Vector3d& p) { return self.Project(p); },
          py::arg("p_C"), "Pixel (u, v) of a point [m] with z > 0, which is not checked.")
      .def(
          "project_with_jacobian",
          [](const PinholeCamera& self, const Eigen::Vector3d& p) {
            Eigen::Matrix<double, 2, 3> jacobian;
            const Eigen::Vector2d uv = self.Project(p, &jacobian);
            return std::pair(uv, jacobian);
          },
          py::arg("p_C"), "The pixel, and its derivative by p_C, 2 x 3.")
      .def("unproject", &PinholeCamera::Unproject, py::arg("uv"), py::arg("z"),
           "The point [m] at depth z [m] behind a pixel.")
      .def("undistort_pixel", &PinholeCamera::UndistortPixel, py::arg("uv"))
      .def("contains", &PinholeCamera::Contains, py::arg("uv"), py::arg("margin") = 0.0);
  py::class_<VirtualRightCamera> right(module, "VirtualRightCamera",
                                       "`baseline` metres to the right: depth as a disparity.");
  KeywordConstructor<VirtualRightCamera>(right);
  right.def_readwrite("fx", &VirtualRightCamera::fx, "[px]")
      .def_readwrite("baseline", &VirtualRightCamera::baseline, "[m]")
      .def("disparity", &VirtualRightCamera::Disparity, py::arg("z"), "[px] of a depth [m]")
      .def("depth", &VirtualRightCamera::Depth, py::arg("disparity"), "[m] of a disparity [px]");
}

}  // namespace

void BindGeometry(py::module_& module) {
  BindPose(module);
  BindLines(module);
  BindCameras(module);
  module.def(
      "so3_exp",
      [](const Eigen::Vector3d& theta) -> Eigen::Vector4d { return so3::Exp(theta).coeffs(); },
      py::arg("theta"), "Quaternion (x, y, z, w) of a rotation vector [rad].");
  module.def(
      "so3_log",
      [](const Eigen::Vector4d& q_xyzw) { return so3::Log(Quaternion(q_xyzw).normalized()); },
      py::arg("q_xyzw"), "Rotation vector [rad] of a quaternion, of length up to pi.");
  module.def(
      "sqrt_information",
      [](const Eigen::MatrixXd& covariance) { return SqrtInformation(covariance); },
      py::arg("covariance"), "W with W^T W = covariance^-1.");
  module.def("parse_stamp", &ParseStamp, py::arg("seconds"),
             "Nanoseconds of seconds in a text, exactly; None for a text that is no number.");
  module.def("format_stamp", &FormatStamp, py::arg("stamp"), "Seconds, with 6 to 9 decimals.");
}

}  // namespace highwall::python
