#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <highwall/factors/white_acceleration.h>

#include "system/measured_pose.h"

namespace highwall {

// How a camera moves, and how much its measured poses scatter beyond what their information states:
// features share errors, such as those of row times, that it does not count.
struct MotionNoise {
  AccelerationNoise acceleration{};
  double position_scale = 1.0;  // > 0: standard deviation over the stated one
  double rotation_scale = 1.0;  // > 0
};

// Estimates both from second differences of the poses, over one step and over two: noise of the
// poses adds the same to either, that of the accelerations eight times as much to the second.
// Medians, so that single jumps do not count. poses: of one world, by stamp. Empty if there are too
// few with information. (docs/factors/white_acceleration.md, Eq. 7 to 9)
std::optional<MotionNoise> EstimateMotionNoise(std::span<const MeasuredPose> poses);

// Returns W with W^T W the information of the pose in the tangent space of PoseManifold, reduced by
// the scales of the noise. It may be singular. pose: with information.
Eigen::Matrix<double, 6, 6> RootInformation(const MeasuredPose& pose, const MotionNoise& noise);

}  // namespace highwall
