#pragma once

#include <span>
#include <vector>

#include <highwall/factors/imu_buffer.h>

namespace highwall {

// Returns how often a sensor's readings are written: 3 if each new one is held for three stamps, as
// by a driver that samples a slower sensor; 1 if they are not repeated regularly. samples: in
// order.
int RepetitionsOf(std::span<const ImuSample> samples, Eigen::Vector3d ImuSample::*sensor);

// Interpolates between the first readings of each run of equal ones.
void InterpolateRepeated(std::vector<ImuSample>& samples, Eigen::Vector3d ImuSample::*sensor);

}  // namespace highwall
