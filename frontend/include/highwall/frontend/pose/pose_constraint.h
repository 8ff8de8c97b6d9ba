#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include <highwall/frontend/features/twist.h>

namespace [[gnu::visibility("default")]] highwall {

// A prior on a pose from another source: rows W (T_WC [-] T_WC_0), as PosePrior.
struct PoseConstraint {
  Pose T_WC;                                      // expected
  Eigen::Matrix<double, 6, 6> sqrt_information =  // W, in the tangent at T_WC [1/m, 1/rad]
      Eigen::Matrix<double, 6, 6>::Zero();
  std::optional<Twist> motion = std::nullopt;  // of the camera, in C, at the same time
};

}  // namespace highwall
