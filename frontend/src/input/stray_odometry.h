#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

namespace highwall {

// One line of odometry.csv of Stray Scanner.
struct StrayPose {
  Stamp stamp = 0;
  std::int64_t frame = 0;                             // number of the image, >= 0
  Pose T_WC;                                          // z forward
  std::optional<std::array<double, 4>> intrinsics{};  // fx fy cx cy [px] where they are stated
};

// Reads lines "timestamp, frame, x, y, z, qx, qy, qz, qw" or columns of these names in any order,
// with fx, fy, cx, cy or without, in the order of the file. Throws IoError naming the line for a
// line of another form, a value that is not finite and a zero quaternion, and IoError if there is
// no line.
std::vector<StrayPose> ReadStrayOdometry(const std::filesystem::path& path);

}  // namespace highwall
