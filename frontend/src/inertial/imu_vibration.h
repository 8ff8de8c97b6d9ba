#pragma once

#include <span>

#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// [m/s^2] how much the accelerometer shakes from reading to reading, RMS of an axis, by the second
// differences of the readings, which smooth motion leaves small. Zero for fewer than three
// readings.
double AccelerometerShake(std::span<const ImuSample> samples);

// The noise of an IMU on a body that shakes. What shakes nearly as fast as the readings come is cut
// off at the ends of an interval and summed wrongly in between: the velocity is off by some
// `share` of shake times the time between two readings, whatever the length of the interval. That
// error joins the accelerometer's noise, as a density over this interval; and so does what a
// reading that is missing would have said, for which those beside it stand: it is off by all of the
// shake. samples: of the whole interval, at least two.
ImuNoise ShakenNoise(const ImuNoise& noise, std::span<const ImuSample> samples,
                     double share = 0.25);

}  // namespace highwall
