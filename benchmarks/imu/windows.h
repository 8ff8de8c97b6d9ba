#pragma once

#include <vector>

#include <Eigen/Core>

#include "recording.h"

namespace highwall::bench {

struct Window {
  ImuPreintegration imu;
  TrueState from, to;
};

struct Windows {
  std::vector<Window> all;
  int skipped = 0;  // with a gap, or beyond the readings
};

// Cuts consecutive windows of at least `length` [s]. They are integrated with their true biases.
Windows Cut(const Recording& recording, double length, const ImuNoise& noise);

// Returns the errors of rotation [rad], velocity [m/s] and position [m] at the end of a window,
// true minus predicted from its start, as in ImuFactor: rotation on the right, the others in the
// frame of the start.
Eigen::Matrix<double, 9, 1> PredictionError(const Window& window, const Eigen::Vector3d& gravity_W);

struct Surroundings {
  Eigen::Vector3d gravity_W;       // [m/s^2]
  ImuBias bias = ImuBias::Zero();  // constant; zero if it was not estimated
};

// Estimates the direction of gravity that fits all windows best, and a bias if `with_bias`, with
// known true states.
Surroundings EstimateSurroundings(const std::vector<Window>& windows, bool with_bias);

}  // namespace highwall::bench
