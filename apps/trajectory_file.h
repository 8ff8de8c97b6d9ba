#pragma once

#include <filesystem>

#include <highwall/core/trajectory.h>

namespace highwall::apps {

enum class TrajectoryFormat {
  kTum,    // stamp tx ty tz qx qy qz qw, separated by blanks
  kKitti,  // the upper 3 x 4 of T, row by row, separated by blanks; no stamps
  kEuroc,  // stamp [ns],px,py,pz,qw,qx,qy,qz,...: a ground truth of EuRoC or TUM-VI
  kRos,    // poses of `rostopic echo -p` or `ros2 topic echo --csv`: PoseStamped,
           // PoseWithCovarianceStamped, Odometry, TransformStamped
};
const char* ToString(TrajectoryFormat format);

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  Trajectory poses;  // those of KITTI are a second apart, from 0 on
};

// The format is told from the first line with numbers, and from the names of the columns where the
// file has them. Quaternions are normalised. Throws IoError "path:line: what" as ReadTumTrajectory,
// also for a matrix that is no rotation.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path);

}  // namespace highwall::apps
