#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Position measurement, for example of a GPS antenna, in a frame G whose pose relative to the world
// is a variable.
//
//   r = W (T_GW T_WB l - p_G)                                 docs/factors/position.md, Eq. 1
//
// Blocks:  0: T_WB  pose (7, PoseManifold) of the body
//          1: T_GW  pose (7, PoseManifold) of the world in the frame of the measurements
// Domain:  everywhere. Evaluate returns false where a value is not finite.
// Source:  Cioffi, Scaramuzza 2020 (see the page).
class PositionFactor final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  using Variables = VariableList<Pose, Pose>;
  enum Block { kPose, kFrame };

  // p_G: [m] measured position. l: [m] lever arm, the position of the measured point in B.
  // sqrt_information: W [1/m], W^T W = Sigma^-1 in the axes of G. Throws InvalidArgument if an
  // argument is not finite.
  PositionFactor(const Eigen::Vector3d& p_G, const Eigen::Vector3d& l,
                 const Eigen::Matrix3d& sqrt_information);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const Eigen::Vector3d& p_G() const { return p_G_; }
  const Eigen::Vector3d& lever_arm() const { return l_; }
  const Eigen::Matrix3d& sqrt_information() const { return W_; }

 private:
  const Eigen::Vector3d p_G_, l_;
  const Eigen::Matrix3d W_;
};

}  // namespace highwall
