#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "system/measured_pose.h"
#include "system/motion_noise.h"

namespace highwall {

// Smooths poses of a body that follow each other, each but the first with the readings of its IMU
// since the one before: a factor graph of measured poses and of ImuGravityFactor between them, with
// velocities, biases and the direction of gravity as unknowns. usual: noise of the poses, where
// they are too few to estimate it (EstimatePoseNoise). gravity_W: [m/s^2] as it is known. Poses
// without information stay as they are. The angular rate is a single reading of the gyroscope;
// beside readings that are missing or were contradicted there is no velocity. Images of one
// keyframe state as much as one, unless the poses would differ from the images by more than those
// can err: then readings err, and the images state more. Empty if even that does not suffice, the
// graph has no solution, or the noise is not known. Linear in the number of poses.
std::vector<SmoothedPose> SmoothByReadings(std::span<const MeasuredPose> poses,
                                           const std::optional<PoseNoise>& usual,
                                           const Eigen::Vector3d& gravity_W);

}  // namespace highwall
