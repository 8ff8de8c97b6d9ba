#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// A pose of a trajectory.
struct StampedPose {
  Stamp stamp = 0;  // [ns]
  Pose pose;        // T_WB, or the pose of the frame of the trajectory
};

// Poses of one moving frame in temporal order: stamps never decrease. Equal neighbours are allowed,
// since motion-capture files contain them.
using Trajectory = std::vector<StampedPose>;

// Reads lines `stamp tx ty tz qx qy qz qw` (seconds, metres, Hamilton quaternion) separated by
// blanks or tabs; empty lines and lines that begin with # are skipped; quaternions are normalised.
// A file without a pose gives an empty trajectory. Throws IoError "path:line: what" for a line that
// does not hold eight numbers, a value that is not finite, a zero quaternion and a decreasing
// stamp; IoError if the file cannot be read.
// Source: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
Trajectory ReadTumTrajectory(const std::filesystem::path& path);

// Writes the same format atomically (AtomicFile). Stamps are read back equal, positions [m] and
// quaternions to 1e-9. Throws InvalidArgument for a pose that is not finite or stamps that decrease
// (ReadTumTrajectory would reject them), IoError if the file cannot be written.
void WriteTumTrajectory(const std::filesystem::path& path, const Trajectory& trajectory);

// Indices of two matched poses.
struct StampMatch {
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

// Matches each pose of the shorter trajectory (the estimate, if both are equally long) to the pose
// of the longer one with the nearest stamp, the earlier one if two are equally near, and keeps
// matches at most `tolerance` [ns] apart. In temporal order; a pose of the longer trajectory may
// occur more than once. Empty if nothing matches. O(n log n). Stamps are compared in double seconds
// (0.2 us for today's UNIX times), as evo does.
// Throws InvalidArgument if stamps decrease or the tolerance is negative.
std::vector<StampMatch> MatchByStamp(const Trajectory& reference, const Trajectory& estimate,
                                     Stamp tolerance);

// Returns the pose at `stamp`: the position by linear interpolation, the rotation by slerp between
// the two neighbours. Empty before the first and after the last pose. O(log n). Requires stamps
// that do not decrease (not checked).
std::optional<Pose> Interpolate(const Trajectory& trajectory, Stamp stamp);

}  // namespace highwall
