#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/silent_domain.h>
#include <highwall/core/variable.h>
#include <highwall/factors/rgbd_projection.h>

namespace [[gnu::visibility("default")]] highwall {

// Residual rows of a point, for the factors below and for pose-only problems:
//   r = W (y - z)                                   docs/factors/point_reprojection.md, Eq. 1, 2
// uv, uvd: the measurement z in undistorted pixels, (u, v) or (u, v, delta).
// sqrt_information: W, with W^T W = Sigma^-1; PointSqrtInformation (depth_noise.h) returns a 3 x 3.
// Throw InvalidArgument if an argument is not finite.
ProjectionRows<2> PointRows(const Eigen::Vector2d& uv, const Eigen::Matrix2d& sqrt_information);
ProjectionRows<3> PointRows(const Eigen::Vector3d& uvd, const Eigen::Matrix3d& sqrt_information);

// Reprojection error of a world point in the left image (2 rows: u, v).
//
//   r = W ( (u, v)(p_C) - z ),   p_C = T_CB T_BW p_W                                       Eq. 1
//
// Blocks:  0: T_WB  pose   (7, PoseManifold)
//          1: p_W   point  (3) [m]
// Domain: p_C.z >= RgbdProjection::min_depth; outside of it r = 0, J = 0 and Evaluate returns true.
class PointReprojection final : public ceres::SizedCostFunction<2, 7, 3>,
                                public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, Point>;
  enum Block { kPose = 0, kPoint = 1 };

  // Arguments and exceptions as PointRows.
  PointReprojection(const Eigen::Vector2d& uv, const Eigen::Matrix2d& sqrt_information,
                    const RgbdProjection& projection)
      : rows_(PointRows(uv, sqrt_information)), projection_(projection) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<2> rows_;
  const RgbdProjection projection_;
};

// PointReprojection with depth (3 rows).
//
//   r = W ( y(p_C) - z ),   y = (u, v, delta)                                              Eq. 2
//
// With the W of Weighting::kPaper the rows are (u, v, u_R) of the virtual right camera.
class PointReprojectionRgbd final : public ceres::SizedCostFunction<3, 7, 3>,
                                    public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, Point>;
  enum Block { kPose = 0, kPoint = 1 };

  // Arguments and exceptions as PointRows.
  PointReprojectionRgbd(const Eigen::Vector3d& uvd, const Eigen::Matrix3d& sqrt_information,
                        const RgbdProjection& projection)
      : rows_(PointRows(uvd, sqrt_information)), projection_(projection) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<3> rows_;
  const RgbdProjection projection_;
};

}  // namespace highwall
