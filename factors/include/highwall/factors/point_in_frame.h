#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Prior on a point in a frame F whose pose in the world is a variable, for example a point of an
// earlier map or a corner of a marker on a body.
//
//   r = W (T_WF^-1 p_W - p_F)                             docs/factors/point_in_frame.md, Eq. 1
//
// Blocks:  0: T_WF  pose (7, PoseManifold) of the frame
//          1: p_W   point (3)
// Domain:  everywhere. Evaluate returns false where a value is not finite.
// Source:  a Gaussian that stands for the observations of the point in F (see the page).
class PointInFrame final : public ceres::SizedCostFunction<3, 7, 3> {
 public:
  using Variables = VariableList<Pose, Point>;
  enum Block { kFrame, kPoint };

  // p_F: [m] known position. sqrt_information: W [1/m], W^T W = Sigma^-1 in the axes of F; rows of
  // zeros in unobservable directions. Throws InvalidArgument if an argument is not finite.
  PointInFrame(const Eigen::Vector3d& p_F, const Eigen::Matrix3d& sqrt_information);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const Eigen::Vector3d& p_F() const { return p_F_; }
  const Eigen::Matrix3d& sqrt_information() const { return W_; }

 private:
  const Eigen::Vector3d p_F_;
  const Eigen::Matrix3d W_;
};

}  // namespace highwall
