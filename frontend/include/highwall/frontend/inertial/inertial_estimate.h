#pragma once

#include <Eigen/Core>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// A state of the body with its uncertainty.
struct InertialEstimate {
  Stamp stamp = 0;  // of the IMU's clock
  ImuState state;   // T_WB, v_WB
  ImuBias bias = ImuBias::Zero();
  // 15 x 15 of [p theta | v | b_g b_a], p and theta in the tangent of PoseManifold.
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Identity();
};

}  // namespace highwall
