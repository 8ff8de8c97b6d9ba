#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <highwall/core/pose.h>

namespace highwall {

// A pose of trajectory.log.
struct LoggedPose {
  std::size_t frame = 0;  // counted from 0
  Pose T_WC;
};

// Reads trajectory.log of Open3D and of Redwood: for each frame a line of three whole numbers, of
// which the first is that of the frame, and a pose (camera to world) of four lines of four numbers.
// Throws IoError naming the line for another form or a matrix that is no pose, and IoError if there
// is none.
// Source: http://redwood-data.org/indoor/fileformat.html
std::vector<LoggedPose> ReadTrajectoryLog(const std::filesystem::path& path);

}  // namespace highwall
