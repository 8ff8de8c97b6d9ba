#pragma once

#include <span>

#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// Returns the vibration of the accelerometer from reading to reading [m/s^2], RMS of an axis, from
// the second differences of the readings, which are small for smooth motion. Zero for fewer than
// three readings.
double AccelerometerShake(std::span<const ImuSample> samples);

// Returns the noise of an IMU on a vibrating body. Vibration nearly as fast as the sampling is cut
// off at the ends of an interval and aliased in between: the velocity error is some `share` of the
// vibration times the sampling interval, whatever the length of the interval. This error is added
// to the accelerometer's noise, as a density over this interval, and so is the error of missing
// readings, which are replaced by their neighbours: it is the full vibration. samples: of the whole
// interval, at least two.
ImuNoise ShakenNoise(const ImuNoise& noise, std::span<const ImuSample> samples,
                     double share = 0.25);

}  // namespace highwall
