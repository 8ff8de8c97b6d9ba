#pragma once

#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>

#include "medians.h"

namespace highwall::bench {

// The errors of an estimate, squared and divided by its own covariance, per degree of freedom: 1
// on average where an estimator knows how well it knows.
//   tilt      2 degrees of freedom: of the vertical, by what is said of gravity
//   velocity  3: in the body's own frame, which no choice of a world moves
//   pose      6: in the world of the first image, which is tilted as the estimate has it
//   bias      6
struct NormalizedErrors {
  double tilt = 0.0, velocity = 0.0, pose = 0.0, bias = 0.0;
};

// T_WV: what takes the world of the truth (V, upright) to that of the estimate. gravity_sigma [rad]
// > 0: InertialReport's.
NormalizedErrors Normalize(const InertialEstimate& estimate, double gravity_sigma,
                           const ImuState& truth, const ImuBias& true_bias, const Pose& T_WV);

// A line: the mean over runs of the errors at the end of each ("end_..._chi2_per_dof"), which are
// independent, and where it lies in 95 % of all cases for an estimator that is consistent. Empty
// where less than two runs have them.
std::string ConsistencyLine(const std::vector<Scores>& runs);

}  // namespace highwall::bench
