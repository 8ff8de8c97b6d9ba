#include <highwall/frontend/input/sensor.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2]

}  // namespace

void ImuCalibration::Validate() const {
  HIGHWALL_REQUIRE(T_BC.IsFinite(), "ImuCalibration::T_BC must be finite");
  noise.Validate();
  HIGHWALL_REQUIRE(std::isfinite(rate) && rate > 0.0,
                   "ImuCalibration::rate must be positive, got " + FixedText(rate));
  HIGHWALL_REQUIRE(
      std::abs(time_offset) <= 1.0,
      "ImuCalibration::time_offset must be in [-1, 1] s, got " + FixedText(time_offset));
  // Written so that infinity passes and NaN does not.
  HIGHWALL_REQUIRE(
      gyroscope_range > 0.0 && (std::isinf(gyroscope_range) || gyroscope_range <= kMaxAngularRate),
      "ImuCalibration::gyroscope_range must be positive and at most 70 rad/s, got " +
          FixedText(gyroscope_range) + "; 1 deg/s is 0.0174533 rad/s");
  HIGHWALL_REQUIRE(accelerometer_range >= kStandardGravity,
                   "ImuCalibration::accelerometer_range must be at least 9.80665 m/s^2, got " +
                       FixedText(accelerometer_range) + "; 1 g is 9.80665 m/s^2");
}

}  // namespace highwall
