#pragma once

#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>

#include "medians.h"

namespace highwall::bench {

// Normalized estimation error squared (NEES): the squared errors of an estimate normalized by its
// own covariance, per degree of freedom: 1 on average for a consistent estimator.
//   tilt      2 degrees of freedom: of the vertical, from the estimate of gravity
//   velocity  3: in the body frame, independent of the choice of the world
//   pose      6: in the world of the first image, with the estimated tilt
//   bias      6
struct NormalizedErrors {
  double tilt = 0.0, velocity = 0.0, pose = 0.0, bias = 0.0;
};

// T_WV: from the world of the truth (V, upright) to that of the estimate. gravity_sigma [rad] > 0:
// InertialReport's.
NormalizedErrors Normalize(const InertialEstimate& estimate, double gravity_sigma,
                           const ImuState& truth, const ImuBias& true_bias, const Pose& T_WV);

// Returns a line with the mean over runs of the errors at the end of each run
// ("end_..._chi2_per_dof"), which are independent, and its 95 % interval for a consistent
// estimator. Empty if fewer than two runs have them.
std::string ConsistencyLine(const std::vector<Scores>& runs);

}  // namespace highwall::bench
