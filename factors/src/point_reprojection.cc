#include <highwall/factors/point_reprojection.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>

namespace highwall {
namespace {

// Implementation of Evaluate: kRows rows on the blocks (pose, point).
template <int kRows>
void EvaluatePoint(const RgbdProjection& projection, const ProjectionRows<kRows>& rows,
                   double const* const* parameters, double* residuals, double** jacobians) {
  const double* T_WB = parameters[0];
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[1]);
  double* J_pose = jacobians ? jacobians[0] : nullptr;
  double* J_point = jacobians ? jacobians[1] : nullptr;

  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 6> dr_dpose;
  Eigen::Matrix<double, kRows, 3> dr_dp_W;
  if (!projection.Evaluate<kRows>(RgbdProjection::At(T_WB), rows, p_W, &r,
                                  J_pose ? &dr_dpose : nullptr, J_point ? &dr_dp_W : nullptr)) {
    r.setZero();
    dr_dpose.setZero();
    dr_dp_W.setZero();
  }
  Eigen::Map<Eigen::Matrix<double, kRows, 1>> out(residuals);
  out = r;
  if (J_pose) PoseManifold::Lift<kRows>(T_WB, dr_dpose, J_pose);
  if (J_point) {
    Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>> J(J_point);
    J = dr_dp_W;
  }
}

}  // namespace

ProjectionRows<2> PointRows(const Eigen::Vector2d& uv, const Eigen::Matrix2d& sqrt_information) {
  HIGHWALL_REQUIRE(uv.allFinite(), "PointRows: the pixel must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "PointRows: sqrt_information must be finite");
  ProjectionRows<2> rows;
  rows.A << sqrt_information, Eigen::Vector2d::Zero();
  rows.b = -sqrt_information * uv;  // Eq. 1
  return rows;
}

ProjectionRows<3> PointRows(const Eigen::Vector3d& uvd, const Eigen::Matrix3d& sqrt_information) {
  HIGHWALL_REQUIRE(uvd.allFinite(), "PointRows: pixel and disparity must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "PointRows: sqrt_information must be finite");
  return {sqrt_information, -sqrt_information * uvd};  // Eq. 2
}

bool PointReprojection::Evaluate(double const* const* parameters, double* residuals,
                                 double** jacobians) const {
  EvaluatePoint(projection_, rows_, parameters, residuals, jacobians);
  return true;
}

bool PointReprojectionRgbd::Evaluate(double const* const* parameters, double* residuals,
                                     double** jacobians) const {
  EvaluatePoint(projection_, rows_, parameters, residuals, jacobians);
  return true;
}

}  // namespace highwall
