#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "bindings.h"
#include "trajectory.h"

namespace highwall::python {
namespace {

using Rows7 = Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>;
using StampVector = Eigen::Matrix<Stamp, Eigen::Dynamic, 1>;

PythonTrajectory FromArrays(const StampVector& stamps, const Rows7& poses) {
  HIGHWALL_REQUIRE(stamps.size() == poses.rows(), "a trajectory has a stamp for each pose");
  PythonTrajectory trajectory;
  for (Eigen::Index i = 0; i < stamps.size(); ++i) {
    trajectory.poses.push_back({stamps[i], Pose::FromBlock(poses.row(i).data())});
  }
  return trajectory;
}

StampVector StampsOf(const PythonTrajectory& trajectory) {
  StampVector stamps(static_cast<Eigen::Index>(trajectory.poses.size()));
  for (Eigen::Index i = 0; i < stamps.size(); ++i) {
    stamps[i] = trajectory.poses[static_cast<std::size_t>(i)].stamp;
  }
  return stamps;
}

Rows7 RowsOf(const PythonTrajectory& trajectory) {
  Rows7 rows(static_cast<Eigen::Index>(trajectory.poses.size()), 7);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Pose& pose = trajectory.poses[static_cast<std::size_t>(i)].pose;
    rows.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 7>>(pose.data());
  }
  return rows;
}

void BindTrajectoryClass(py::module_& module) {
  py::class_<PythonTrajectory>(module, "Trajectory", "Stamps [ns] and poses, in the order of time.")
      .def(py::init(&FromArrays), py::arg("stamps"), py::arg("poses"),
           "stamps: n, integers. poses: n x 7, x y z [m] and quaternion x y z w.")
      .def_static(
          "read_tum",
          [](const py::object& path) { return PythonTrajectory{ReadTumTrajectory(Path(path))}; },
          py::arg("path"))
      .def(
          "write_tum",
          [](const PythonTrajectory& trajectory, const py::object& path) {
            WriteTumTrajectory(Path(path), trajectory.poses);
          },
          py::arg("path"))
      .def_property_readonly("stamps", &StampsOf, "[ns]")
      .def_property_readonly("poses", &RowsOf, "n x 7: x y z qx qy qz qw")
      .def(
          "interpolate",
          [](const PythonTrajectory& trajectory, Stamp stamp) {
            return Interpolate(trajectory.poses, stamp);
          },
          py::arg("stamp"), "The Pose at a stamp; None before the first and after the last.")
      .def("__len__", [](const PythonTrajectory& trajectory) { return trajectory.poses.size(); })
      .def("__getitem__", [](const PythonTrajectory& trajectory, std::size_t i) {
        if (i >= trajectory.poses.size()) throw py::index_error();
        return std::pair(trajectory.poses[i].stamp, trajectory.poses[i].pose);
      });
}

using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

void BindErrorOptions(py::module_& module) {
  py::enum_<TrajectoryAlignment>(module, "TrajectoryAlignment")
      .value("NONE", TrajectoryAlignment::kNone)
      .value("SE3", TrajectoryAlignment::kSe3)
      .value("SIM3", TrajectoryAlignment::kSim3)
      .value("SCALE", TrajectoryAlignment::kScale)
      .value("ORIGIN", TrajectoryAlignment::kOrigin);
  py::enum_<PoseRelation>(module, "PoseRelation")
      .value("TRANSLATION", PoseRelation::kTranslation)
      .value("ANGLE_DEGREES", PoseRelation::kAngleDegrees)
      .value("FULL", PoseRelation::kFull);
  py::enum_<DeltaUnit>(module, "DeltaUnit")
      .value("FRAMES", DeltaUnit::kFrames)
      .value("METRES", DeltaUnit::kMetres);
}

void BindErrors(py::module_& module) {
  py::class_<ErrorStatistics>(module, "ErrorStatistics",
                              "Of n errors, in their unit (sse: squared).")
      .def_readonly("max", &ErrorStatistics::max)
      .def_readonly("mean", &ErrorStatistics::mean)
      .def_readonly("median", &ErrorStatistics::median)
      .def_readonly("min", &ErrorStatistics::min)
      .def_readonly("rmse", &ErrorStatistics::rmse)
      .def_readonly("sse", &ErrorStatistics::sse)
      .def_readonly("std", &ErrorStatistics::std);
  py::class_<TrajectoryError>(module, "TrajectoryError",
                              "Errors, and the trajectories that they are of.")
      .def_readonly("statistics", &TrajectoryError::statistics)
      .def_property_readonly(
          "errors",
          [](const TrajectoryError& error) -> Eigen::VectorXd {
            return Eigen::Map<const Eigen::VectorXd>(
                error.errors.data(), static_cast<Eigen::Index>(error.errors.size()));
          },
          "One a matched pose, or a pair of them.")
      .def_property_readonly(
          "reference",
          [](const TrajectoryError& error) { return PythonTrajectory{error.reference}; })
      .def_property_readonly(
          "estimate", [](const TrajectoryError& error) { return PythonTrajectory{error.estimate}; },
          "Aligned, at its own stamps.")
      .def_readonly("scale", &TrajectoryError::scale)
      .def_readonly("time_covered", &TrajectoryError::time_covered);
}

}  // namespace

void BindTrajectory(py::module_& module) {
  BindTrajectoryClass(module);
  BindErrorOptions(module);
  BindErrors(module);
  const AbsolutePoseErrorOptions absolute;
  module.def(
      "absolute_pose_error",
      [](const PythonTrajectory& reference, const PythonTrajectory& estimate,
         TrajectoryAlignment alignment, PoseRelation relation, double t_max_diff) {
        return AbsolutePoseError(
            reference.poses, estimate.poses,
            {.t_max_diff = t_max_diff, .alignment = alignment, .relation = relation});
      },
      py::arg("reference"), py::arg("estimate"), py::arg("alignment") = absolute.alignment,
      py::arg("relation") = absolute.relation, py::arg("t_max_diff") = absolute.t_max_diff,
      "APE; the figures are those of evo. t_max_diff [s].");
  py::class_<Similarity>(module, "Similarity", "p_A = scale R_AB p_B + t_AB.")
      .def_readonly("scale", &Similarity::scale)
      .def_readonly("T_AB", &Similarity::T_AB)
      .def("__mul__", &Similarity::operator*, py::arg("T_BC"),
           "Rotates, scales and moves the position; rotates the attitude.");
  module.def(
      "align_umeyama",
      [](const Rows3& a, const Rows3& b, bool with_scale) {
        return AlignUmeyama(a.transpose(), b.transpose(), with_scale);
      },
      py::arg("a"), py::arg("b"), py::arg("with_scale") = false,
      "The Similarity, rigid unless with_scale, that lays b on a by least squares; both n x 3 "
      "[m]. None where the points do not determine it.");
  const RelativePoseErrorOptions relative;
  module.def(
      "relative_pose_error",
      [](const PythonTrajectory& reference, const PythonTrajectory& estimate, double delta,
         DeltaUnit delta_unit, bool all_pairs, TrajectoryAlignment alignment, PoseRelation relation,
         double t_max_diff) {
        return RelativePoseError(reference.poses, estimate.poses,
                                 {.t_max_diff = t_max_diff,
                                  .alignment = alignment,
                                  .relation = relation,
                                  .delta = delta,
                                  .delta_unit = delta_unit,
                                  .all_pairs = all_pairs});
      },
      py::arg("reference"), py::arg("estimate"), py::arg("delta") = relative.delta,
      py::arg("delta_unit") = relative.delta_unit, py::arg("all_pairs") = relative.all_pairs,
      py::arg("alignment") = relative.alignment, py::arg("relation") = relative.relation,
      py::arg("t_max_diff") = relative.t_max_diff,
      "RPE over pairs `delta` matched poses or metres apart. t_max_diff [s].");
}

}  // namespace highwall::python
