#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/silent_domain.h>
#include <highwall/core/variable.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/factors/rgbd_projection.h>

namespace [[gnu::visibility("default")]] highwall {

// Reprojection error of a world point with the camera's focal lengths and principal point, the
// offset of its inverse depth and its depth distortion pattern as variables. The pose is that of
// the camera.
//
//   r = A y(p_C; k, o, g) + b,   y = (fx x/z + cx, fy y/z + cy, c (1/z + o + w^T g))
//                                                  docs/factors/intrinsic_reprojection.md, Eq. 1
//
// c is not a variable: the third row measures depth in metres, whatever the pixels are.
//
// Blocks:  0: T_WC  pose                  (7, PoseManifold)
//          1: p_W   point                 (3) [m]
//          2: k     intrinsics            (4) [fx fy cx cy], px
//          3: o     inverse depth offset  (1) [1/m], RgbdSensor::inverse_depth_offset
//          4: g     nodes of the pattern  (20) [1/m], DepthPattern::nodes
// Domain: as PointReprojection; outside of it r = 0, J = 0 and Evaluate returns true.
class IntrinsicReprojection final
    : public ceres::SizedCostFunction<3, 7, 3, 4, 1, DepthPattern::kNodes>,
      public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, Point, Eigen::Vector4d, double, DepthPattern::Vector>;
  enum Block { kPose = 0, kPoint = 1, kIntrinsics = 2, kInverseDepthOffset = 3, kPattern = 4 };

  // rows: PointRows(), with a third row of zeros for a point without depth. projection: only its c
  // = fx b and its min_depth are used. shares: w, DepthPattern::Shares() of the pixel. Throws
  // InvalidArgument if the rows or the shares are not finite.
  IntrinsicReprojection(const ProjectionRows<3>& rows, const RgbdProjection& projection,
                        const DepthPattern::Vector& shares);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<3> rows_;
  const DepthPattern::Vector shares_;
  const double c_, min_depth_;
};

}  // namespace highwall
