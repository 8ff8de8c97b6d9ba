#pragma once

#include <span>

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/variable.h>
#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// Zero-velocity pseudo-measurement of a stationary body.
//
//   r = v_WB / sigma                                     docs/factors/zero_velocity.md, Eq. 1
//
// Blocks:  0: v_WB  velocity (3) [m/s]
// Domain:  everywhere.
class ZeroVelocity final : public ceres::SizedCostFunction<3, 3> {
 public:
  using Variables = VariableList<Eigen::Vector3d>;

  // sigma: [m/s] > 0. Throws InvalidArgument if it is not.
  explicit ZeroVelocity(double sigma = 0.01);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const double inverse_sigma_;
};

// Options of IsStationary().
struct StationaryOptions {
  double gyroscope_sigma = 0.005;     // [rad/s] > 0; of one reading at rest, including vibration
  double accelerometer_sigma = 0.05;  // [m/s^2] > 0; likewise
  double max_statistic = 3.0;         // > 0; at rest the statistic is 1 on average
  double max_rate = 0.1;              // [rad/s] > 0; of the mean reading: bias or steady rotation
  double min_duration = 0.2;          // [s] > 0; a shorter window never counts as rest

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns the mean square deviation of the readings from their mean, in units of their variance at
// rest (Eq. 2). samples: at least 2. Throws InvalidArgument if there are fewer, and on bad options.
double StationaryStatistic(std::span<const ImuSample> samples,
                           const StationaryOptions& options = {});

// Returns whether the IMU readings are consistent with a stationary body. Motion at constant
// velocity without rotation cannot be distinguished, so check the images as well. False if a sample
// is not finite.
bool IsStationary(std::span<const ImuSample> samples, const StationaryOptions& options = {});

}  // namespace highwall
