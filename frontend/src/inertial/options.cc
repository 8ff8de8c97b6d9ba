#include <highwall/frontend/inertial/options.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

void ImuWeightingOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(fixed_weight) && fixed_weight > 0.0,
                   "ImuWeightingOptions::fixed_weight must be positive");
  paper.Validate();
  consistent.Validate();
}

void InertialInitializerOptions::Validate() const {
  const auto require = [](double value, const char* field) {
    HIGHWALL_REQUIRE(std::isfinite(value) && value > 0.0,
                     std::string("InertialInitializerOptions::") + field + " must be positive");
  };
  require(interval, "interval");
  require(min_duration, "min_duration");
  require(gyroscope_bias_sigma, "gyroscope_bias_sigma");
  require(accelerometer_bias_sigma, "accelerometer_bias_sigma");
  require(time_offset_sigma, "time_offset_sigma");
  require(max_gravity_sigma, "max_gravity_sigma");
  require(max_error, "max_error");
  HIGHWALL_REQUIRE(max_duration > min_duration && std::isfinite(max_duration),
                   "InertialInitializerOptions::max_duration must exceed min_duration");
  HIGHWALL_REQUIRE(max_gravity_error > 0.0 && max_gravity_error < 1.0,
                   "InertialInitializerOptions::max_gravity_error must be in (0, 1)");
}

void VisualNoise::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(position) && position > 0.0,
                   "VisualNoise::position must be positive");
  HIGHWALL_REQUIRE(std::isfinite(rotation) && rotation > 0.0,
                   "VisualNoise::rotation must be positive");
  HIGHWALL_REQUIRE(std::isfinite(scale) && scale > 0.0, "VisualNoise::scale must be positive");
  HIGHWALL_REQUIRE(std::isfinite(min_error) && min_error > 0.0,
                   "VisualNoise::min_error must be positive");
}

void InertialOptions::Validate() const {
  weighting.Validate();
  initializer.Validate();
  window.Validate();
  buffer.Validate();
  visual_noise.Validate();
  stationary.Validate();
  const auto require = [](double value, const char* field) {
    HIGHWALL_REQUIRE(std::isfinite(value) && value > 0.0,
                     std::string("InertialOptions::") + field + " must be positive");
  };
  require(retry_interval, "retry_interval");
  require(max_dead_reckoning, "max_dead_reckoning");
  require(restart_velocity_sigma, "restart_velocity_sigma");
  require(stationary_speed, "stationary_speed");
  HIGHWALL_REQUIRE(walk_inflation >= 1.0 && std::isfinite(walk_inflation),
                   "InertialOptions::walk_inflation must be at least 1");
  HIGHWALL_REQUIRE(prediction_inflation >= 1.0 && std::isfinite(prediction_inflation),
                   "InertialOptions::prediction_inflation must be at least 1");
  HIGHWALL_REQUIRE(max_attempts >= 1, "InertialOptions::max_attempts must be at least 1");
}

const char* ToString(ImuWeighting policy) {
  switch (policy) {
    case ImuWeighting::kPaper:
      return "paper";
    case ImuWeighting::kConsistent:
      return "consistent";
    case ImuWeighting::kFixed:
      return "fixed";
  }
  return "unknown";
}

}  // namespace highwall
