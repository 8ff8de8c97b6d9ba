#pragma once

#include <limits>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>

namespace highwall {

// How the axes of a camera lie in a body, and how far its clock is off.
struct AxesAlignment {
  Eigen::Quaterniond q_BC = Eigen::Quaterniond::Identity();
  double time_offset = 0.0;                                  // [s] to 1 ms
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();  // [rad/s]
  double error = 0.0;                                        // [rad] RMS of a turn that is left
  double excitation = 0.0;  // [rad] RMS of the turns about the axis they have least of
};

// From the turns between neighbouring poses against those of the gyroscope, whatever the place of
// the camera: rotations in closed form for each offset within +-max_time_offset [s], the one that
// leaves least. poses: at least 8, in order; pairs farther apart than max_interval [s], without
// readings, or with some that end at gyroscope_range [rad/s] are left out. Throws InvalidArgument
// where fewer than 8 pairs remain.
AxesAlignment AlignAxes(const Trajectory& poses, const ImuBuffer& readings, double max_time_offset,
                        double max_interval,
                        double gyroscope_range = std::numeric_limits<double>::infinity());

}  // namespace highwall
