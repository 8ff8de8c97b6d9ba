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
  Pose pose;        // T_WB, or of whichever frame the trajectory is
};

// Poses of one moving frame in the order of time: no stamp is smaller than the one before it.
// Equal neighbours are allowed, since motion-capture files hold them.
using Trajectory = std::vector<StampedPose>;

// Reads lines `stamp tx ty tz qx qy qz qw` (seconds, metres, Hamilton quaternion) separated by
// blanks or tabs; empty lines and lines that begin with # are skipped; quaternions are normalised.
// A file without a pose gives an empty trajectory. Throws IoError "path:line: what" for a line with
// other than eight numbers, a value that is not finite, a zero quaternion and a stamp that goes
// back in time; IoError if the file cannot be read.
// Source: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
Trajectory ReadTumTrajectory(const std::filesystem::path& path);

// Writes the same form, whole or not at all (AtomicFile). Stamps come back equal, positions [m] and
// quaternions to 1e-9. Throws InvalidArgument for a pose that is not finite or stamps that decrease
// (ReadTumTrajectory would refuse them), IoError if the file cannot be written.
void WriteTumTrajectory(const std::filesystem::path& path, const Trajectory& trajectory);

// Indices of two poses that belong together.
struct StampMatch {
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

// For each pose of the shorter trajectory (the estimate, if both are equally long) the pose of the
// longer one with the nearest stamp, the earlier of two that are equally near, kept where they are
// at most `tolerance` [ns] apart. In the order of time; a pose of the longer trajectory may occur
// more than once. Empty where nothing matches. O(n log n). Which of two is nearer is decided in
// double seconds (0.2 us for today's UNIX times), as evo does.
// Throws InvalidArgument if stamps decrease or the tolerance is negative.
std::vector<StampMatch> MatchByStamp(const Trajectory& reference, const Trajectory& estimate,
                                     Stamp tolerance);

// The pose at `stamp`: position linear, rotation by slerp between the two neighbours. Empty before
// the first and after the last pose. O(log n). Requires stamps that do not decrease (not checked).
std::optional<Pose> Interpolate(const Trajectory& trajectory, Stamp stamp);

}  // namespace highwall
