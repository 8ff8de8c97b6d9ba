#pragma once

#include <memory>

#include <ceres/cost_function.h>

#include <highwall/core/abi.h>
#include <highwall/core/silent_domain.h>

namespace [[gnu::visibility("default")]] highwall {

// Any factor of what a camera sees, with the pose of the camera on the body as one more variable:
//
//   r = r_seen( T_WB T_BC, ... )                       docs/factors/extrinsic_factor.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold)
//          1..: those of the factor behind its pose
//          last: T_BC  pose (7, PoseManifold)
// Domain: that of the factor at the camera's pose.
// Source: Kelly, Sukhatme, "Visual-inertial sensor fusion", IJRR 2011, section 3; for points alone:
// ExtrinsicReprojection.
class ExtrinsicFactor final : public ceres::CostFunction, public SilentOutsideDomain {
 public:
  // seen: its block 0 is T_WC, as where the camera's frame is the body's. Throws InvalidArgument
  // without a factor on a pose.
  explicit ExtrinsicFactor(std::shared_ptr<const ceres::CostFunction> seen);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::shared_ptr<const ceres::CostFunction> seen_;
};

}  // namespace highwall
