#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

// Octree that follows the poses of its keyframes: SetPose() sets their current poses, Rebuild()
// incrementally updates the map.
//
// Clamped log-odds cannot be subtracted, so the bricks of 8^3 voxels that a moved keyframe touched
// before or touches now are refilled from all keyframes that touch them, in the order of ids; if at
// least half of the keyframes moved, the whole map is refilled. This is done in a copy, which
// replaces the region in one step when it is complete: map() is a complete map at any time. The
// result equals, leaf for leaf, a map built from scratch with these poses.
//
// A keyframe that has moved by less than 1 cm and half a degree since it was last merged into the
// map is not moved. A keyframe's scan is stored as the mean points of voxels of half the resolution
// in its camera frame, 6 bytes per point. Not thread-safe.
class KeyframeOctree {
 public:
  // Throws InvalidArgument naming the field.
  explicit KeyframeOctree(const OctomapBuilderOptions& options = {});
  ~KeyframeOctree();

  // Adds keyframe `id`. If its id is the largest so far, it is merged into the map immediately,
  // otherwise by Rebuild(), which also removes a scan that was replaced. points_C [m] as in
  // OctomapBuilder::Insert(). Throws InvalidArgument as that does.
  void SetKeyframe(std::int64_t id, std::span<const Eigen::Vector3f> points_C, const Pose& T_WC);
  // Throws InvalidArgument if there is no keyframe `id` or T_WC is not finite.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Does nothing if there is no such keyframe.
  void RemoveKeyframe(std::int64_t id);
  // Moves keyframe `id`, with its stored scan unchanged, to another octree of the same resolution,
  // in whose W its pose is T_WC; it replaces a keyframe of the same id there. Both maps wait for
  // Rebuild(). Throws as SetPose(), and InvalidArgument for another resolution.
  void MoveKeyframe(std::int64_t id, const Pose& T_WC, KeyframeOctree& to);

  // Works for `budget` or one keyframe, whichever takes longer, plus, in the last call, the time to
  // replace the region. Returns true once the map is up to date. A pose that changes in the
  // meantime waits for the next round; a keyframe that is removed or replaced restarts the round.
  bool Rebuild(std::chrono::duration<double> budget = std::chrono::duration<double>::max());
  // Returns whether all keyframes are in the map at their current poses.
  bool IsCurrent() const;

  const OctomapBuilder& map() const;
  // Returns the map and removes all keyframes.
  OctomapBuilder TakeMap();
  std::size_t KeyframeCount() const;
  // Returns the memory of the stored scans and lists of bricks in bytes.
  std::size_t ScanBytes() const;

 private:
  void RequireKeyframe(std::int64_t id, const Pose& T_WC) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
