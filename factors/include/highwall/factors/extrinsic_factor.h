#pragma once

#include <memory>

#include <ceres/cost_function.h>

#include <highwall/core/abi.h>
#include <highwall/core/silent_domain.h>

namespace [[gnu::visibility("default")]] highwall {

// Wraps any factor on the pose of a camera, with the camera extrinsics T_BC as an additional
// variable:
//
//   r = r_seen( T_WB T_BC, ... )                       docs/factors/extrinsic_factor.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold)
//          1..: blocks of the wrapped factor after its pose
//          last: T_BC  pose (7, PoseManifold)
// Domain: that of the wrapped factor at the camera pose.
// Source: Kelly, Sukhatme, "Visual-inertial sensor fusion", IJRR 2011, section 3.
class ExtrinsicFactor final : public ceres::CostFunction, public SilentOutsideDomain {
 public:
  // seen: the wrapped factor; its block 0 is T_WC, the pose of a camera frame that coincides with
  // the body. Throws InvalidArgument without a factor whose first block is a pose.
  explicit ExtrinsicFactor(std::shared_ptr<const ceres::CostFunction> seen);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::shared_ptr<const ceres::CostFunction> seen_;
};

}  // namespace highwall
