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
// velocities, biases and the direction of gravity as unknowns. usual: noise of the
// poses, where they are too few to estimate it (EstimatePoseNoise). gravity_W: [m/s^2] as it is
// known. Poses without information stay as they are. The angular rate is that of
// the gyroscope; beside readings that were contradicted there is no velocity. Empty if the graph
// has no solution, or the noise is not known. Linear in the number of poses.
std::vector<SmoothedPose> SmoothByReadings(std::span<const MeasuredPose> poses,
                                           const std::optional<PoseNoise>& usual,
                                           const Eigen::Vector3d& gravity_W);

}  // namespace highwall
