#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Residual row of a measured surface point against a plane known from elsewhere. Value type: the
// cost function holds one, and a tracker evaluates it in its own pose-only problem.
struct PointToPlaneRow {
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  // unit normal of the plane, in the frame R
  Eigen::Vector3d a = Eigen::Vector3d::Zero();   // [m] a point of the plane, in R
  Eigen::Vector3d p = Eigen::Vector3d::Zero();   // [m] the measured point, in the body B
  double inverse_sigma = 1.0;                    // [1/m] of the point-to-plane distance

  // r = n . (T_RB p - a) / sigma                        docs/factors/point_to_plane.md, Eq. 1
  // and, where not null, its Jacobian in the tangent of PoseManifold at T_RB.
  double Evaluate(const Eigen::Matrix3d& R_RB, const Eigen::Vector3d& p_RB,
                  Eigen::Matrix<double, 1, 6>* dr_dpose) const {
    const double r = inverse_sigma * n.dot(R_RB * p + p_RB - a);  // Eq. 1
    if (dr_dpose == nullptr) return r;
    dr_dpose->leftCols<3>() = inverse_sigma * n.transpose();  // Eq. 2
    dr_dpose->rightCols<3>() = inverse_sigma * p.cross(R_RB.transpose() * n).transpose();
    return r;
  }
};

// Distance between a point measured by one body and a plane measured by another.
//
//   r = n . (T_WR^-1 T_WB p - a) / sigma                  docs/factors/point_to_plane.md, Eq. 1
//
// Blocks:  0: T_WR  pose (7, PoseManifold) of the body that observed the plane
//          1: T_WB  pose (7, PoseManifold) of the body that observed the point
// Domain:  everywhere.
// Source:  Chen, Medioni 1992 (see the page).
class PointToPlane final : public ceres::SizedCostFunction<1, 7, 7> {
 public:
  using Variables = VariableList<Pose, Pose>;
  enum Block { kReference, kPose };

  // Throws InvalidArgument if a value is not finite, n is not of unit length or inverse_sigma is
  // not positive.
  explicit PointToPlane(const PointToPlaneRow& row);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PointToPlaneRow row_;
};

}  // namespace highwall
