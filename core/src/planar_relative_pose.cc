#include "planar_relative_pose.h"

#include <cmath>

#include "planar_pose.h"

namespace highwall::internal {
namespace {

Eigen::Matrix3d RotateFirst(const Eigen::Matrix3d& W, double theta_z) {
  const double c = std::cos(theta_z), s = std::sin(theta_z);
  Eigen::Matrix3d Rz_transposed;
  Rz_transposed << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  return W * Rz_transposed;
}

}  // namespace

PlanarRelativePose::PlanarRelativePose(const Eigen::Vector3d& Z,
                                       const Eigen::Matrix3d& sqrt_information)
    : Z_(Z), W_Rz_(RotateFirst(sqrt_information, Z.z())) {}

bool PlanarRelativePose::Evaluate(double const* const* parameters, double* residuals,
                                  double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> x_i(parameters[0]), x_j(parameters[1]);
  const double c = std::cos(x_i[2]), s = std::sin(x_i[2]);
  const double dx = x_j[0] - x_i[0], dy = x_j[1] - x_i[1];
  const double x_ij = c * dx + s * dy, y_ij = -s * dx + c * dy;  // R_i^T (p_j - p_i)
  const Eigen::Vector3d e(x_ij - Z_[0], y_ij - Z_[1], WrapAngle(x_j[2] - x_i[2] - Z_[2]));
  if (!e.allFinite()) return false;
  Eigen::Map<Eigen::Vector3d> r(residuals);
  r = W_Rz_ * e;  // Eq. 2
  if (jacobians == nullptr) return true;

  using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  if (jacobians[0] != nullptr) {
    Eigen::Matrix3d de_di;
    de_di << -c, -s, y_ij, s, -c, -x_ij, 0.0, 0.0, -1.0;
    Eigen::Map<RowMajor3> J(jacobians[0]);
    J.noalias() = W_Rz_ * de_di;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Matrix3d de_dj;
    de_dj << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
    Eigen::Map<RowMajor3> J(jacobians[1]);
    J.noalias() = W_Rz_ * de_dj;
  }
  return true;
}

}  // namespace highwall::internal
