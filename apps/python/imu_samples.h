#pragma once

#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <Eigen/Core>

namespace highwall::python {

using Stamps = Eigen::Matrix<Stamp, Eigen::Dynamic, 1>;
using Readings = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// Throws InvalidArgument unless all have the same length.
std::vector<ImuSample> ImuSamples(const Stamps& stamps, const Readings& gyroscope,
                                  const Readings& accelerometer);

}  // namespace highwall::python
