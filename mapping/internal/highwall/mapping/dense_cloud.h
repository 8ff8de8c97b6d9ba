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
  double voxel_size = 0.01;  // [m] > 0; one point a voxel
  int max_observations = 6;  // [1, 256] points that a voxel averages, later ones are dropped
  // A keyframe that moved less than both, since it was last put into the cloud, stays where it is.
  double min_translation = 0.01;           // [m] >= 0
  double min_rotation = 0.5 * 0.01745329;  // [rad] >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The dense map: the clouds of keyframes, each stored in its own camera frame, and their union in
// W, voxel-filtered, in blocks of 64^3 voxels.
//
// SetPose() says where a keyframe is now, Rebuild() makes the blocks right again that moved
// keyframes touched or touch, a bit at a time; Merged() shows the old blocks until the new ones are
// complete. The result equals, point for point, a cloud built from scratch of the same stored
// clouds and poses.
//
// Memory is bounded by the area seen, not by the number of keyframes: a stored point takes 12 bytes
// (positions to 1/32767 of the farthest one), and points that fall into a voxel of
// max_observations points when their keyframe joins are not stored at all (one that comes from
// another cloud has been through that). Not thread-safe.
class DenseCloud {
 public:
  // Throws InvalidArgument naming the field.
  explicit DenseCloud(const DenseCloudOptions& options = {});
  ~DenseCloud();

  // Adds keyframe `id`, or replaces its cloud; it joins the map with its first pose.
  void SetKeyframe(std::int64_t id, std::span<const ColoredPoint> cloud_C);
  // The first pose of the largest id so far puts the keyframe into the map at once, other changes
  // wait for Rebuild(). Throws InvalidArgument if `id` has no cloud or T_WC is not finite.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Does nothing where there is no such keyframe.
  void RemoveKeyframe(std::int64_t id);
  // Hands keyframe `id` over to another cloud, in whose W it stands at T_WC, or there replaces one:
  // all its stored points, to the bit. Both clouds wait for Rebuild(). Throws as SetPose().
  void MoveKeyframe(std::int64_t id, const Pose& T_WC, DenseCloud& to);

  // Works for `budget` or one keyframe, whichever takes longer. True once the map is right. A pose
  // that changes meanwhile waits for the next round; a keyframe that is removed or replaced starts
  // it again.
  bool Rebuild(std::chrono::duration<double> budget = std::chrono::duration<double>::max());
  // Whether all keyframes that have a pose are in the map, where it wants them.
  bool IsCurrent() const;

  bool Contains(std::int64_t id) const;
  std::size_t KeyframeCount() const;
  // Stored points of all keyframes.
  std::size_t PointCount() const;
  // Bytes of stored points and blocks.
  std::size_t MemoryBytes() const;

  // The points in W, block by block. A function of the content alone.
  std::vector<ColoredPoint> Merged() const;
  // Puts everything in place, hands the points over and forgets all keyframes: in less memory than
  // Rebuild() and Merged() take, as nobody looks at the old blocks any more.
  std::vector<ColoredPoint> TakeMerged();

 private:
  void RequireKeyframe(std::int64_t id, const Pose& T_WC) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
