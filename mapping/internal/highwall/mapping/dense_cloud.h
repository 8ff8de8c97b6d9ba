#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

struct DenseCloudOptions {
  double voxel_size = 0.01;  // [m] > 0; one point per voxel
  int max_observations = 6;  // [1, 256] points averaged per voxel; later ones are dropped

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Dense point map: the clouds of keyframes, each stored in its own camera frame, and their union in
// W, voxel-filtered, in blocks of 64^3 voxels.
//
// SetPose() sets the current pose of a keyframe, which is not moved if it has moved by less than
// 1 cm and half a degree since it was last merged into the cloud; Rebuild() incrementally updates
// the blocks that moved keyframes touched before or touch now; Merged() returns the old blocks
// until the new ones are complete. The result equals, point for point, a cloud built from scratch
// from the same stored clouds and poses.
//
// Memory is bounded by the observed area, not by the number of keyframes: a stored point takes 12
// bytes (positions are quantized to 1/32767 of the farthest one), and points that fall into a voxel
// of max_observations points when their keyframe is merged are not stored at all (a keyframe moved
// from another cloud has already been reduced). Not thread-safe.
class DenseCloud {
 public:
  // Throws InvalidArgument naming the field.
  explicit DenseCloud(const DenseCloudOptions& options = {});
  ~DenseCloud();

  // Adds keyframe `id`, or replaces its cloud; it is merged into the map with its first pose.
  void SetKeyframe(std::int64_t id, std::span<const ColoredPoint> cloud_C);
  // Sets the pose of a keyframe. The first pose of the largest id so far merges the keyframe into
  // the map immediately; other changes wait for Rebuild(). Throws InvalidArgument if `id` has no
  // cloud or T_WC is not finite.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Does nothing if there is no such keyframe.
  void RemoveKeyframe(std::int64_t id);
  // Moves keyframe `id`, with all its stored points unchanged, to another cloud, in whose W its
  // pose is T_WC; it replaces a keyframe of the same id there. Both clouds wait for Rebuild().
  // Throws as SetPose().
  void MoveKeyframe(std::int64_t id, const Pose& T_WC, DenseCloud& to);

  // Works for `budget` or one keyframe, whichever takes longer. Returns true once the map is up to
  // date. A pose that changes in the meantime waits for the next round; a keyframe that is removed
  // or replaced restarts the round.
  bool Rebuild(std::chrono::duration<double> budget = std::chrono::duration<double>::max());
  // Returns whether all keyframes that have a pose are in the map at that pose.
  bool IsCurrent() const;

  bool Contains(std::int64_t id) const;
  std::size_t KeyframeCount() const;
  // Returns the number of stored points of all keyframes.
  std::size_t PointCount() const;
  // Returns the memory of stored points and blocks in bytes.
  std::size_t MemoryBytes() const;

  // Returns the points in W, block by block. The result depends on the content alone.
  std::vector<ColoredPoint> Merged() const;
  // Completes the map, returns its points and removes all keyframes. It takes less memory than
  // Rebuild() and Merged(), as the old blocks are no longer needed.
  std::vector<ColoredPoint> TakeMerged();

 private:
  void RequireKeyframe(std::int64_t id, const Pose& T_WC) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
