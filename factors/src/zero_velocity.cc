#include <highwall/factors/zero_velocity.h>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

struct Means {
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();
};

Means MeansOf(std::span<const ImuSample> samples) {
  Means means;
  for (const ImuSample& sample : samples) {
    means.gyroscope += sample.gyroscope;
    means.accelerometer += sample.accelerometer;
  }
  means.gyroscope /= static_cast<double>(samples.size());
  means.accelerometer /= static_cast<double>(samples.size());
  return means;
}

}  // namespace

ZeroVelocity::ZeroVelocity(double sigma) : inverse_sigma_(1.0 / sigma) {
  RequirePositiveFinite(sigma, "ZeroVelocity: sigma");
}

bool ZeroVelocity::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  for (int i = 0; i < 3; ++i) residuals[i] = inverse_sigma_ * parameters[0][i];  // Eq. 1
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    for (int i = 0; i < 9; ++i) jacobians[0][i] = i % 4 == 0 ? inverse_sigma_ : 0.0;
  }
  return true;
}

void StationaryOptions::Validate() const {
  RequirePositiveFinite(gyroscope_sigma, "StationaryOptions::gyroscope_sigma");
  RequirePositiveFinite(accelerometer_sigma, "StationaryOptions::accelerometer_sigma");
  RequirePositiveFinite(max_statistic, "StationaryOptions::max_statistic");
  RequirePositiveFinite(max_rate, "StationaryOptions::max_rate");
  RequirePositiveFinite(min_duration, "StationaryOptions::min_duration");
}

double StationaryStatistic(std::span<const ImuSample> samples, const StationaryOptions& options) {
  options.Validate();
  HIGHWALL_REQUIRE(samples.size() >= 2, "StationaryStatistic needs at least 2 samples, has " +
                                            std::to_string(samples.size()));
  const Means means = MeansOf(samples);
  double gyroscope = 0.0, accelerometer = 0.0;
  for (const ImuSample& sample : samples) {
    gyroscope += (sample.gyroscope - means.gyroscope).squaredNorm();
    accelerometer += (sample.accelerometer - means.accelerometer).squaredNorm();
  }
  gyroscope /= options.gyroscope_sigma * options.gyroscope_sigma;
  accelerometer /= options.accelerometer_sigma * options.accelerometer_sigma;
  // Eq. 2: six axes; the mean uses one degree of freedom of each.
  return (gyroscope + accelerometer) / (6.0 * static_cast<double>(samples.size() - 1));
}

bool IsStationary(std::span<const ImuSample> samples, const StationaryOptions& options) {
  options.Validate();
  if (samples.size() < 2) return false;
  const double duration = ToSeconds(samples.back().stamp - samples.front().stamp);
  return duration >= options.min_duration &&
         StationaryStatistic(samples, options) <= options.max_statistic &&
         MeansOf(samples).gyroscope.norm() <= options.max_rate;
}

}  // namespace highwall
