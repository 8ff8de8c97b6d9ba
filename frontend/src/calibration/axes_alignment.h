#pragma once

#include <limits>
#include <optional>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>

namespace highwall {

// Rotation between a camera and a body, and the offset of their clocks.
struct AxesAlignment {
  Eigen::Quaterniond q_BC = Eigen::Quaterniond::Identity();
  double time_offset = 0.0;                                  // [s] with a resolution of 1 ms
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();  // [rad/s]
  double error = 0.0;                                        // [rad] RMS of the residual rotations
  double excitation = 0.0;  // [rad] RMS of the rotations about their second weakest axis
};

// Estimates the alignment from the rotations between neighbouring poses and those of the gyroscope,
// independently of the lever arm: rotations in closed form for each offset within +-max_time_offset
// [s], of which the one with the least residual is chosen. poses: at least 8, in order; pairs
// farther apart than max_interval [s], without readings, or with readings saturated at
// gyroscope_range [rad/s] are ignored. Empty if fewer than 8 pairs remain.
std::optional<AxesAlignment> AlignAxes(
    const Trajectory& poses, const ImuBuffer& readings, double max_time_offset, double max_interval,
    double gyroscope_range = std::numeric_limits<double>::infinity());

}  // namespace highwall
