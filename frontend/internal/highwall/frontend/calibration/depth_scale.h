#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

struct DepthScaleOptions {
  double prior_sigma = 0.1;               // > 0: of the scale, prior 1
  double position_sigma = 5e-4;           // [m] > 0: of the motion between two keyframes, and
  double position_share = 4e-3;           // >= 0: of the distance, added to it
  double rotation_sigma = 5e-4;           // [rad] > 0
  double gyroscope_bias_sigma = 0.02;     // [rad/s] > 0: of the biases, prior zero
  double accelerometer_bias_sigma = 0.1;  // [m/s^2] > 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Ratio of the metric scale of the depth to that of the IMU.
struct DepthScale {
  double scale = 1.0;  // true depth = scale x measured depth
  double sigma = 0.0;  // that of the prior if the motion does not observe it
  int keyframes = 0;   // number of keyframes used
  // chi-squared per degree of freedom: about 1; above it sigma is scaled with it
  double error = 0.0;
};

// Returns a copy of the map adjusted by its images alone, without the IMU, which pulls keyframes
// towards the true scale.
Map AdjustedWithoutImu(const Map& map, const MeasurementModel& model,
                       const BundleAdjustmentOptions& options = {});

// Compares the motion between keyframes in the map with the IMU readings between them:
// docs/inertial_odometry.md, "The scale of the depth". Empty if fewer than three consecutive
// keyframes are connected by IMU factors, or the problem cannot be solved. map: of
// AdjustedWithoutImu(). Throws InvalidArgument for bad options.
std::optional<DepthScale> EstimateDepthScale(const Map& map, const Pose& T_BC,
                                             const DepthScaleOptions& options = {});

}  // namespace highwall
