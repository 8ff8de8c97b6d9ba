#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "inertial/imu_saturation.h"
#include "support/imu_scene.h"

namespace highwall::imu_saturation_test {
namespace {

constexpr double kGyroscopeRange = 8.0, kAccelerometerRange = 20.0;  // [rad/s], [m/s^2]
constexpr double kRate = 200.0;                                      // [Hz]

ImuCalibration WithRanges() {
  ImuCalibration calibration;
  calibration.gyroscope_range = kGyroscopeRange;
  calibration.accelerometer_range = kAccelerometerRange;
  return calibration;
}

// Returns a tenth of a second of readings at rest.
std::vector<ImuSample> Rest() {
  return SinusoidalMotion(0.0).Samples(kRate, 0.1);
}

TEST(ImuSaturation, AReadingAtEitherEndOfAnAxisIsSaturatedAndOneBelowItIsNot) {
  const ImuCalibration calibration = WithRanges();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      ImuSample sample;
      EXPECT_FALSE(IsSaturated(sample, calibration));
      sample.accelerometer[axis] = sign * kAccelerometerRange;
      EXPECT_TRUE(IsSaturated(sample, calibration));
      sample.accelerometer[axis] = sign * 0.99 * kAccelerometerRange;
      EXPECT_FALSE(IsSaturated(sample, calibration));
      sample.gyroscope[axis] = sign * 0.9995 * kGyroscopeRange;  // a 12-bit sensor rounds so
      EXPECT_TRUE(IsSaturated(sample, calibration));
    }
  }
}

TEST(ImuSaturation, WithoutARangeNothingIsSaturated) {
  ImuSample sample;
  sample.accelerometer.x() = kMaxSpecificForce;
  sample.gyroscope.x() = kMaxAngularRate;
  EXPECT_FALSE(IsSaturated(sample, ImuCalibration()));
  std::vector<ImuSample> samples = Rest();
  samples[5] = {samples[5].stamp, sample.gyroscope, sample.accelerometer};
  const ImuNoise noise;
  const ImuNoise same = SaturatedNoise(noise, samples, ImuCalibration());
  EXPECT_EQ(same.accelerometer, noise.accelerometer);
  EXPECT_EQ(same.gyroscope, noise.gyroscope);
}

TEST(ImuSaturation, TheVelocityIsOffByHalfOfTheRangeOverTheTimeOfTheReadings) {
  std::vector<ImuSample> samples = Rest();
  ASSERT_EQ(samples.size(), 21U);
  for (int i = 4; i < 8; ++i) samples[static_cast<std::size_t>(i)].accelerometer.y() = -20.0;
  const ImuNoise noise;
  const ImuNoise saturated = SaturatedNoise(noise, samples, WithRanges());
  EXPECT_EQ(saturated.gyroscope, noise.gyroscope);
  EXPECT_EQ(saturated.accelerometer_walk, noise.accelerometer_walk);
  // A noise density times the square root of the interval is a velocity.
  const double velocity = 0.5 * kAccelerometerRange * 4.0 / kRate;
  const double added = std::sqrt(saturated.accelerometer * saturated.accelerometer -
                                 noise.accelerometer * noise.accelerometer);
  EXPECT_NEAR(added * std::sqrt(0.1), velocity, 1e-9);  // the numbers are about 0.2
}

TEST(ImuSaturation, TheGyroscopeHasAnEndOfItsOwn) {
  std::vector<ImuSample> samples = Rest();
  samples.front().gyroscope.z() = kGyroscopeRange;  // represents the half step after it
  const ImuNoise noise;
  const ImuNoise saturated = SaturatedNoise(noise, samples, WithRanges());
  EXPECT_EQ(saturated.accelerometer, noise.accelerometer);
  const double angle = 0.5 * kGyroscopeRange * 0.5 / kRate;
  const double added =
      std::sqrt(saturated.gyroscope * saturated.gyroscope - noise.gyroscope * noise.gyroscope);
  EXPECT_NEAR(added * std::sqrt(0.1), angle, 1e-9);
}

}  // namespace
}  // namespace highwall::imu_saturation_test
