#pragma once

#include <cmath>
#include <random>

#include <Eigen/Core>

#include <highwall/core/pose.h>

// Model of drifting odometry: noise drawn at every step, and a bias that is constant for the walk.
namespace highwall::testing {

// Standard deviations along and about each axis.
struct OdometryDrift {
  double noise_translation = 0.01;             // share of the step
  double noise_rotation = 0.1 * M_PI / 180.0;  // [rad] a step
  double bias_translation = 0.005;             // share of the step
  double bias_rotation = 0.01 * M_PI / 180.0;  // [rad] a step
  unsigned seed = 1;
};

class DriftingOdometry {
 public:
  explicit DriftingOdometry(const OdometryDrift& drift) : drift_(drift), rng_(drift.seed) {
    bias_translation_ = Normal(drift.bias_translation);
    bias_rotation_ = Normal(drift.bias_rotation);
  }

  // Returns the measurement of the true step Z.
  Pose Measure(const Pose& Z) {
    const Eigen::Vector3d share = bias_translation_ + Normal(drift_.noise_translation);
    const Eigen::Vector3d turn = bias_rotation_ + Normal(drift_.noise_rotation);
    return Z * Pose::FromTangent(Z.p().norm() * share, turn);
  }

 private:
  Eigen::Vector3d Normal(double sigma) {
    const double x = normal_(rng_), y = normal_(rng_);
    return sigma * Eigen::Vector3d(x, y, normal_(rng_));
  }

  OdometryDrift drift_;
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  Eigen::Vector3d bias_translation_, bias_rotation_;
};

}  // namespace highwall::testing
