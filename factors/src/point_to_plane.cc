#include <highwall/factors/point_to_plane.h>

#include <cmath>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>

namespace highwall {

PointToPlane::PointToPlane(const PointToPlaneRow& row) : row_(row) {
  HIGHWALL_REQUIRE(row.n.allFinite() && row.a.allFinite() && row.p.allFinite(),
                   "PointToPlane: plane and point must be finite");
  HIGHWALL_REQUIRE(std::abs(row.n.norm() - 1.0) < 1e-6,
                   "PointToPlane: the normal must have the length 1");
  HIGHWALL_REQUIRE(std::isfinite(row.inverse_sigma) && row.inverse_sigma > 0.0,
                   "PointToPlane: inverse_sigma must be positive");
}

bool PointToPlane::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_WR(parameters[kReference]), p_WB(parameters[kPose]);
  const Eigen::Map<const Eigen::Quaterniond> q_WR(parameters[kReference] + 3);
  const Eigen::Map<const Eigen::Quaterniond> q_WB(parameters[kPose] + 3);
  const Eigen::Matrix3d R_RW = q_WR.toRotationMatrix().transpose();
  const Eigen::Matrix3d R_RB = R_RW * q_WB.toRotationMatrix();
  const Eigen::Vector3d p_RB = R_RW * (p_WB - p_WR);

  Eigen::Matrix<double, 1, 6> dr_dT_RB;
  residuals[0] = row_.Evaluate(R_RB, p_RB, jacobians != nullptr ? &dr_dT_RB : nullptr);
  if (!std::isfinite(residuals[0])) return false;
  if (jacobians == nullptr) return true;

  const Eigen::RowVector3d dr_dp_W = dr_dT_RB.leftCols<3>() * R_RW;
  if (jacobians[kReference] != nullptr) {  // Eq. 4
    const Eigen::Vector3d p_R = R_RB * row_.p + p_RB;
    Eigen::Matrix<double, 1, 6> J;
    J << -dr_dp_W, row_.inverse_sigma * row_.n.cross(p_R).transpose();
    PoseManifold::Lift<1>(parameters[kReference], J, jacobians[kReference]);
  }
  if (jacobians[kPose] != nullptr) {  // Eq. 3
    Eigen::Matrix<double, 1, 6> J;
    J << dr_dp_W, dr_dT_RB.rightCols<3>();
    PoseManifold::Lift<1>(parameters[kPose], J, jacobians[kPose]);
  }
  return true;
}

}  // namespace highwall
