#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>

namespace highwall::apps {

enum class TrajectoryFormat {
  kTum,       // stamp tx ty tz qx qy qz qw, seconds, separated by blanks
  kKitti,     // the upper 3 x 4 of T, row by row; no stamps
  kMatrices,  // all 16 numbers of T, row by row; no stamps
  kEuroc,     // stamp [ns],px,py,pz,qw,qx,qy,qz,...: a ground truth of EuRoC or TUM-VI
  kRos,       // poses of `rostopic echo -p` or `ros2 topic echo --csv`: PoseStamped,
              // PoseWithCovarianceStamped, Odometry, TransformStamped
  kTable,     // any other table with a stamp, a position and a quaternion in each line
};
const char* ToString(TrajectoryFormat format);
bool HasStamps(TrajectoryFormat format);

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  Trajectory poses{};                 // those without stamps are a second apart, from 0 on
  std::vector<std::int64_t> lines{};  // line numbers in the file, one per pose
  std::string assumed{};              // assumptions not based on heading or values, as a sentence
};

// Columns and the unit of time follow the heading, if any, otherwise they are inferred from the
// values: docs/evaluation.md. Values are separated by blanks, commas or semicolons; a heading may
// begin with # or % or with neither. Quaternions are normalised. A file without a pose gives an
// empty result. Throws IoError "path:line: what" as ReadTumTrajectory, also for a matrix that is
// not a rotation.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path);

// Poses with equal stamps cannot be matched. The later of two is removed, as recorded in `assumed`,
// if these are fewer than one in a thousand, as in motion capture with rounded stamps. Otherwise
// throws IoError naming the line.
void RequireDistinctStamps(const std::filesystem::path& path, TrajectoryFile* file);

}  // namespace highwall::apps
