#include <highwall/factors/imu_preintegration.h>

#include <cmath>
#include <string>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/core/sqrt_information.h>
#include <highwall/internal/require.h>

#include "imu_integrator.h"

namespace highwall {
namespace {

// Returns the slope at the middle of three readings, from the parabola through them. Where one step
// is more than twice the other (a gap, or a reading interpolated at an image), it returns the slope
// of the longer step: that of the shorter would carry its noise over the whole longer step.
Eigen::Vector3d Slope(double h_before, const Eigen::Vector3d& slope_before, double h_after,
                      const Eigen::Vector3d& slope_after) {
  if (h_before > 2.0 * h_after) return slope_before;
  if (h_after > 2.0 * h_before) return slope_after;
  return (h_after * slope_before + h_before * slope_after) / (h_before + h_after);
}

}  // namespace

void ImuNoise::Validate() const {
  RequirePositiveFinite(gyroscope, "ImuNoise::gyroscope");
  RequirePositiveFinite(accelerometer, "ImuNoise::accelerometer");
  RequirePositiveFinite(gyroscope_walk, "ImuNoise::gyroscope_walk");
  RequirePositiveFinite(accelerometer_walk, "ImuNoise::accelerometer_walk");
}

void ImuPreintegrationOptions::Validate() const {
  noise.Validate();
  RequirePositiveFinite(max_gyroscope_change, "ImuPreintegrationOptions::max_gyroscope_change");
  RequirePositiveFinite(max_accelerometer_change,
                        "ImuPreintegrationOptions::max_accelerometer_change");
}

ImuDelta::Motion ImuDelta::At(const ImuBias& other) const {
  const Eigen::Matrix<double, 9, 1> d = bias_jacobian * (other - bias);  // Eq. 7
  return {q * so3::Exp(d.head<3>()), v + d.segment<3>(3), p + d.tail<3>()};
}

ImuPreintegration::ImuPreintegration(std::span<const ImuSample> samples, const ImuBias& bias,
                                     const ImuPreintegrationOptions& options)
    : samples_(samples.begin(), samples.end()), options_(options) {
  options_.Validate();
  HIGHWALL_REQUIRE(samples_.size() >= 2, "ImuPreintegration needs at least 2 samples, has " +
                                             std::to_string(samples_.size()));
  HIGHWALL_REQUIRE(bias.allFinite(), "ImuPreintegration: the bias must be finite");
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const ImuSample& sample = samples_[i];
    HIGHWALL_REQUIRE(
        sample.gyroscope.allFinite() && sample.accelerometer.allFinite(),
        "ImuPreintegration: the sample at " + FormatStamp(sample.stamp) + " s must be finite");
    HIGHWALL_REQUIRE(i == 0 || samples_[i - 1].stamp < sample.stamp,
                     "ImuPreintegration: the stamps do not increase at " +
                         FormatStamp(sample.stamp) + " s; ImuBuffer puts them in order");
  }
  delta_.bias = bias;
  Integrate();
}

void ImuPreintegration::Integrate() {
  const Eigen::Vector3d b_g = delta_.bias.head<3>(), b_a = delta_.bias.tail<3>();
  ImuIntegrator integrator(options_.noise);
  ImuIntegrator::Knot from;
  double h = 0.0;          // length of the latest measured step
  Eigen::Vector3d dw, da;  // slopes of that step
  const auto measure_step = [&](std::size_t i) {
    h = ToSeconds(samples_[i].stamp - samples_[i - 1].stamp);
    dw = (samples_[i].gyroscope - samples_[i - 1].gyroscope) / h;
    da = (samples_[i].accelerometer - samples_[i - 1].accelerometer) / h;
  };
  measure_step(1);
  for (std::size_t i = 1; i < samples_.size(); ++i) {
    const bool first = i == 1, last = i + 1 == samples_.size();
    const double step = h;
    const Eigen::Vector3d dw_step = dw, da_step = da;
    ImuIntegrator::Knot to{samples_[i].gyroscope - b_g, samples_[i].accelerometer - b_a, dw, da};
    if (!last) {
      measure_step(i + 1);
      to.dw = Slope(step, dw_step, h, dw);
      to.da = Slope(step, da_step, h, da);
    }
    // At the ends, the parabola through the three outermost readings is used: the mean of its
    // slopes at both ends of a step is the slope of the step.
    if (first) {
      from = {samples_[0].gyroscope - b_g, samples_[0].accelerometer - b_a, 2.0 * dw_step - to.dw,
              2.0 * da_step - to.da};
    } else if (last) {
      to.dw = 2.0 * dw_step - from.dw;
      to.da = 2.0 * da_step - from.da;
    }
    integrator.Step(step, from, to);
    from = to;
  }
  integrator.Export(&delta_, &covariance_);
}

ImuState ImuPreintegration::Predict(const ImuState& start, const ImuBias& bias,
                                    const Eigen::Vector3d& gravity_W) const {
  const ImuDelta::Motion motion = delta_.At(bias);
  const Eigen::Quaterniond q_i = start.T_WB.q();
  const double T = delta_.duration;
  // Eq. 8
  const Eigen::Vector3d p =
      start.T_WB.p() + T * start.v_WB + 0.5 * T * T * gravity_W + q_i * motion.p;
  return {Pose(q_i * motion.q, p), start.v_WB + T * gravity_W + q_i * motion.v};
}

bool ImuPreintegration::NeedsReintegration(const ImuBias& bias) const {
  const ImuBias change = bias - delta_.bias;
  return !(change.head<3>().norm() <= options_.max_gyroscope_change &&
           change.tail<3>().norm() <= options_.max_accelerometer_change);
}

bool ImuPreintegration::HasInformation() const {
  std::string fault;
  return internal::TrySqrtInformation(covariance_, &fault).has_value();
}

ImuPreintegration ImuPreintegration::Reintegrated(const ImuBias& bias) const {
  return ImuPreintegration(samples_, bias, options_);
}

ImuPreintegration ImuPreintegration::Joined(const ImuPreintegration& next) const {
  HIGHWALL_REQUIRE(next.start() == end(),
                   "ImuPreintegration::Joined: the next interval must start where this one ends");
  std::vector<ImuSample> samples = samples_;
  samples.insert(samples.end(), next.samples_.begin() + 1, next.samples_.end());
  const ImuNoise& a = options_.noise;
  const ImuNoise& b = next.options_.noise;
  const double share = next.delta_.duration / (delta_.duration + next.delta_.duration);
  // White noise and random walks accumulate variance over time: that of the merged interval equals
  // the sum of both.
  const auto mean = [share](double of_a, double of_b) {
    return std::sqrt((1.0 - share) * of_a * of_a + share * of_b * of_b);
  };
  ImuPreintegrationOptions options = options_;
  options.noise = {.gyroscope = mean(a.gyroscope, b.gyroscope),
                   .accelerometer = mean(a.accelerometer, b.accelerometer),
                   .gyroscope_walk = mean(a.gyroscope_walk, b.gyroscope_walk),
                   .accelerometer_walk = mean(a.accelerometer_walk, b.accelerometer_walk)};
  return ImuPreintegration(samples, delta_.bias, options);
}

}  // namespace highwall
