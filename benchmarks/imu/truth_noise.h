#pragma once

#include <map>

#include <Eigen/Core>

#include "windows.h"

namespace highwall::bench {

// Standard deviations of ground truth's own errors, an axis. Those of its orientation last for
// seconds: they come with where the markers are, so that over a short window most of them cancel.
struct TruthNoise {
  double orientation = 0.0;           // [rad]
  double velocity = 0.0;              // [m/s]
  double position = 0.0;              // [m]
  std::map<double, double> rotation;  // [rad] of the rotation over a window, by its length [s]

  // Of PredictionError() of a window, the IMU's own on top. An error of the orientation at the
  // start turns what is predicted from there.
  Eigen::Matrix<double, 9, 9> Covariance(const Window& window) const;
};

// The median of chi-square with three degrees of freedom.
inline constexpr double kMedianOfChi2 = 2.366;

// From what the windows of other lengths than `left_out` [s] are off beyond the noise of the IMU:
// rotations of up to 16 s, to which an IMU adds little and in which both ends err on their own;
// velocities and positions of 0.1 s, in which an IMU and a tilt have no time to.
TruthNoise EstimateTruthNoise(const Recording& recording, const ImuNoise& noise,
                              const Eigen::Vector3d& gravity_W, double left_out);

}  // namespace highwall::bench
