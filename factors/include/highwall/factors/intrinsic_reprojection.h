#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>
#include <highwall/factors/rgbd_projection.h>

namespace [[gnu::visibility("default")]] highwall {

// Reprojection error of a world point with the camera's focal lengths and principal point, and the
// offset of its depth, as variables; its pose is that of the camera itself.
//
//   r = A y(p_C; k, o) + b,   y = (fx x/z + cx, fy y/z + cy, c (1/z + o))
//                                                  docs/factors/intrinsic_reprojection.md, Eq. 1
//
// c is no variable: the third row measures depth in metres, whatever the pixels are.
//
// Blocks:  0: T_WC  pose                  (7, PoseManifold)
//          1: p_W   point                 (3) [m]
//          2: k     intrinsics            (4) [fx fy cx cy], px
//          3: o     inverse depth offset  (1) [1/m], RgbdSensor::inverse_depth_offset
// Domain: as PointReprojection; outside of it r = 0, J = 0 and Evaluate is true.
class IntrinsicReprojection final : public ceres::SizedCostFunction<3, 7, 3, 4, 1> {
 public:
  using Variables = VariableList<Pose, Point, Eigen::Vector4d, double>;
  enum Block { kPose = 0, kPoint = 1, kIntrinsics = 2, kInverseDepthOffset = 3 };

  // rows: of PointRows(), where there is no depth with a third row of zeros. projection: its c =
  // fx b and its min_depth count. Throws InvalidArgument if the rows are not finite.
  IntrinsicReprojection(const ProjectionRows<3>& rows, const RgbdProjection& projection);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<3> rows_;
  const double c_, min_depth_;
};

}  // namespace highwall
