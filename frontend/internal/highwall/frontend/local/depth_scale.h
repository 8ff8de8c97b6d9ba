#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

struct DepthScaleOptions {
  double prior_sigma = 0.1;               // > 0: of the scale, about 1
  double position_sigma = 5e-4;           // [m] > 0: of the motion between two keyframes, and
  double position_share = 4e-3;           // >= 0: of the distance, added to it
  double rotation_sigma = 5e-4;           // [rad] > 0
  double gyroscope_bias_sigma = 0.02;     // [rad/s] > 0: of the biases, about zero
  double accelerometer_bias_sigma = 0.1;  // [m/s^2] > 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How long the metre of the depth is against that of the IMU.
struct DepthScale {
  double scale = 1.0;  // true depth = scale x measured depth
  double sigma = 0.0;  // that of the prior where the motion does not tell
  int keyframes = 0;   // that took part
  double error = 0.0;  // chi-squared per degree of freedom: about 1; beyond it sigma grows with it
};

// The map as its images alone have it: a copy, adjusted without the IMU, which draws keyframes
// towards the true scale.
Map AdjustedWithoutImu(const Map& map, const MeasurementModel& model,
                       const BundleAdjustmentOptions& options = {});

// Compares the motion between keyframes, as the map shows it, with the readings of the IMU between
// them: docs/inertial_odometry.md, "The scale of the depth". Empty where fewer than three keyframes
// in a row are tied by an IMU, or the problem cannot be solved.
// map: of AdjustedWithoutImu(). Throws InvalidArgument on bad options.
std::optional<DepthScale> EstimateDepthScale(const Map& map, const Pose& T_BC,
                                             const DepthScaleOptions& options = {});

}  // namespace highwall
