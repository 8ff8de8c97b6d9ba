#pragma once

#include <filesystem>
#include <span>

#include <highwall/frontend/system/slam_system.h>

namespace highwall::apps {

// Writes for each frame a line of its stamp [s], v_WC [m/s], omega_C [rad/s] and the upper triangle
// of the covariance of both, row by row. Atomic. Throws IoError.
void WriteVelocities(const std::filesystem::path& path, std::span<const FrameVelocity> velocities);

}  // namespace highwall::apps
