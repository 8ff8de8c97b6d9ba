#pragma once

#include <span>

#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Whether a reading of three axes ends at `range`, within a thousandth of that: it was as much or
// more.
bool EndsAt(const Eigen::Vector3d& reading, double range);

// Whether a reading ends where its sensor does (ImuCalibration::gyroscope_range,
// accelerometer_range).
bool IsSaturated(const ImuSample& sample, const ImuCalibration& calibration);

// The noise of an IMU of which some readings are saturated. How far the truth was beyond the range
// is not known, and for neighbouring readings it is the same error: half of the range, over all of
// the time that they stand for. As a density over this interval that joins the noise of the sensor
// whose readings they are. samples: of the whole interval, at least two.
ImuNoise SaturatedNoise(const ImuNoise& noise, std::span<const ImuSample> samples,
                        const ImuCalibration& calibration);

}  // namespace highwall
