#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <highwall/factors/imu_preintegration.h>
#include <highwall/factors/white_acceleration.h>

#include "system/measured_pose.h"

namespace highwall {

// How much measured poses scatter beyond what their information states: features share errors, such
// as those of row times, that it does not count.
struct PoseNoise {
  double position = 1.0;  // > 0: standard deviation over the stated one
  double rotation = 1.0;  // > 0
};

// How a camera moves, and how much its poses scatter.
struct MotionNoise {
  AccelerationNoise acceleration{};
  PoseNoise pose{};
};

// Estimates both from second differences of the poses, over one step and over two: noise of the
// poses adds the same to either, that of the accelerations eight times as much to the second.
// Medians, so that single jumps do not count. poses: of one world, by stamp. Empty if there are too
// few with information. (docs/factors/white_acceleration.md, Eq. 7 to 9)
std::optional<MotionNoise> EstimateMotionNoise(std::span<const MeasuredPose> poses);

// Estimates the noise of poses with readings of an IMU between them: from what the second
// differences differ by from those that the readings predict, whatever the motion. poses: as above.
// readings: one for each pose but the first, since the one before. gravity_W: [m/s^2]. Empty as
// above. (docs/factors/white_acceleration.md, Eq. 10 and 11)
std::optional<PoseNoise> EstimatePoseNoise(std::span<const MeasuredPose> poses,
                                           std::span<const ImuPreintegration> readings,
                                           const Eigen::Vector3d& gravity_W);

// Returns W with W^T W the information of the pose in the tangent space of PoseManifold, reduced by
// the noise. It may be singular. pose: with information.
Eigen::Matrix<double, 6, 6> RootInformation(const MeasuredPose& pose, const PoseNoise& noise);

}  // namespace highwall
