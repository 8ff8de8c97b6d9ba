#include <highwall/frontend/input/sensor.h>

#include <cmath>
#include <string>

#include <highwall/core/error.h>

namespace highwall {

void ImuCalibration::Validate() const {
  HIGHWALL_REQUIRE(T_BC.IsFinite(), "ImuCalibration::T_BC must be finite");
  noise.Validate();
  HIGHWALL_REQUIRE(std::isfinite(rate) && rate > 0.0,
                   "ImuCalibration::rate must be positive, got " + std::to_string(rate));
  HIGHWALL_REQUIRE(
      std::abs(time_offset) <= 1.0,
      "ImuCalibration::time_offset must be in [-1, 1] s, got " + std::to_string(time_offset));
  // Infinity passes, a number that is none does not.
  HIGHWALL_REQUIRE(gyroscope_range > 0.0, "ImuCalibration::gyroscope_range must be positive, got " +
                                              std::to_string(gyroscope_range));
  HIGHWALL_REQUIRE(accelerometer_range > 0.0,
                   "ImuCalibration::accelerometer_range must be positive, got " +
                       std::to_string(accelerometer_range));
}

}  // namespace highwall
