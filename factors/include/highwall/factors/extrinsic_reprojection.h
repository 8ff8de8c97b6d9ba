#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/silent_domain.h>
#include <highwall/core/variable.h>
#include <highwall/factors/point_reprojection.h>

namespace [[gnu::visibility("default")]] highwall {

// Reprojection error of a world point with the camera extrinsics T_BC as a variable.
//
//   r = W ( y(p_C) - z ),   p_C = T_BC^-1 T_WB^-1 p_W                                      Eq. 1
//                                                  docs/factors/extrinsic_reprojection.md
//
// Blocks:  0: T_WB  pose   (7, PoseManifold)
//          1: p_W   point  (3) [m]
//          2: T_BC  pose   (7, PoseManifold)
// Domain: as PointReprojection; outside of it r = 0, J = 0 and Evaluate returns true.
template <int kRows>
class ExtrinsicReprojection final : public ceres::SizedCostFunction<kRows, 7, 3, 7>,
                                    public SilentOutsideDomain {
  static_assert(kRows == 2 || kRows == 3, "(u, v) or (u, v, disparity)");

 public:
  using Variables = VariableList<Pose, Point, Pose>;
  using Vector = Eigen::Matrix<double, kRows, 1>;
  using Matrix = Eigen::Matrix<double, kRows, kRows>;
  enum Block { kPose = 0, kPoint = 1, kExtrinsics = 2 };

  // z: (u, v) [px] or (u, v, disparity). The T_BC of `projection` is not used. Throws
  // InvalidArgument if an argument is not finite.
  ExtrinsicReprojection(const Vector& z, const Matrix& sqrt_information,
                        const RgbdProjection& projection)
      : rows_(PointRows(z, sqrt_information)), projection_(projection) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<kRows> rows_;
  const RgbdProjection projection_;
};

// Variants without and with depth.
using PointReprojectionExtrinsics = ExtrinsicReprojection<2>;
using PointReprojectionRgbdExtrinsics = ExtrinsicReprojection<3>;

extern template class ExtrinsicReprojection<2>;
extern template class ExtrinsicReprojection<3>;

}  // namespace highwall
