#pragma once

#include <span>

#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Returns whether a reading of three axes is saturated: at `range`, within a thousandth of it.
bool EndsAt(const Eigen::Vector3d& reading, double range);

// Returns whether a reading is saturated (ImuCalibration::gyroscope_range, accelerometer_range).
bool IsSaturated(const ImuSample& sample, const ImuCalibration& calibration);

// Returns the noise of an IMU with some saturated readings. By how much the truth exceeded the
// range is unknown, and neighbouring readings share the same error: half of the range, over the
// whole time that they stand for. As a density over this interval, it is added to the noise of the
// saturated sensor. samples: of the whole interval, at least two.
ImuNoise SaturatedNoise(const ImuNoise& noise, std::span<const ImuSample> samples,
                        const ImuCalibration& calibration);

}  // namespace highwall
