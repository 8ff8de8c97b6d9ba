#pragma once

#include <map>

#include <Eigen/Core>

#include "windows.h"

namespace highwall::bench {

// Standard deviations of the ground truth's own errors per axis. The orientation errors are
// correlated over seconds, because they depend on the marker positions: over a short window most of
// them cancel.
struct TruthNoise {
  double orientation = 0.0;           // [rad]
  double velocity = 0.0;              // [m/s]
  double position = 0.0;              // [m]
  std::map<double, double> rotation;  // [rad] of the rotation over a window, by its length [s]

  // Returns the covariance of PredictionError() of a window, including the IMU's own. An
  // orientation error at the start rotates the prediction.
  Eigen::Matrix<double, 9, 9> Covariance(const Window& window) const;
};

// Median of chi-square with three degrees of freedom.
inline constexpr double kMedianOfChi2 = 2.366;

// Estimates the noise from the errors of windows of other lengths than `left_out` [s] that exceed
// the noise of the IMU: rotations over up to 16 s, where the IMU contributes little and the errors
// at both ends are independent; velocities and positions over 0.1 s, where IMU and tilt contribute
// little.
TruthNoise EstimateTruthNoise(const Recording& recording, const ImuNoise& noise,
                              const Eigen::Vector3d& gravity_W, double left_out);

}  // namespace highwall::bench
