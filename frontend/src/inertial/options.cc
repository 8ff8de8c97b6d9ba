#include <highwall/frontend/inertial/options.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void ImuWeightingOptions::Validate() const {
  RequirePositiveFinite(fixed_weight, "ImuWeightingOptions::fixed_weight");
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
  RequirePositiveFinite(position, "VisualNoise::position");
  RequirePositiveFinite(rotation, "VisualNoise::rotation");
  RequirePositiveFinite(scale, "VisualNoise::scale");
  RequirePositiveFinite(min_error, "VisualNoise::min_error");
}

void InertialOptions::Validate() const {
  weighting.Validate();
  initializer.Validate();
  buffer.Validate();
  visual_noise.Validate();
  RequirePositiveFinite(max_dead_reckoning, "InertialOptions::max_dead_reckoning");
  RequireAtLeast(window_states, 2, "InertialOptions::window_states");
  RequireAtLeast(max_attempts, 1, "InertialOptions::max_attempts");
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
