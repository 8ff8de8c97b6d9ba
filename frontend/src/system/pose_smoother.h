#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "system/measured_pose.h"

namespace highwall {

// Returns the poses of a world with each held by its image and by its neighbours in time: a factor
// graph of measured poses and, between them, of white noise on the acceleration
// (WhiteAcceleration), whose densities it estimates from the poses themselves, or of the readings
// of an IMU (ImuGravityFactor). Across gaps nothing holds. Linear in the number of poses, in
// windows of bounded memory. poses: by stamp. gravity_W: [m/s^2] empty: readings are not used.
// Empty where a pose is not smoothed. (docs/tracking.md, Smoothing)
std::vector<std::optional<SmoothedPose>> SmoothPoses(
    std::span<const MeasuredPose> poses,
    const std::optional<Eigen::Vector3d>& gravity_W = std::nullopt);

// Returns the last of the poses as the images before it predict it: the same posterior of the last
// seconds, with densities estimated from them. poses: by stamp; the last one, of which no image
// states anything, is where the solution starts. Empty if there are too few of them without a gap.
std::optional<Pose> PredictLastPose(std::span<const MeasuredPose> poses);

}  // namespace highwall
