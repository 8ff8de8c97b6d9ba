#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

struct KeyframeOctreeOptions {
  OctomapBuilderOptions octree;
  // A keyframe that moved less than both, since it was last put into the map, stays where it is.
  double min_translation = 0.01;           // [m] >= 0
  double min_rotation = 0.5 * 0.01745329;  // [rad] >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// An octree that follows its keyframes: SetPose() says where they are now, Rebuild() makes the map
// right again, a bit at a time.
//
// Clamped log-odds cannot be taken back, so the bricks of 8^3 voxels that a moved keyframe touched
// or touches are filled again from all keyframes that touch them, in the order of ids; from half of
// the keyframes on the whole map is. That happens in a copy, which replaces the region at once when
// it is complete: map() is a whole map at any time. The result equals, leaf for leaf, a map built
// from scratch with these poses.
//
// A keyframe's scan is stored as the mean points of voxels of half the resolution in its camera
// frame, 6 bytes a point. Not thread-safe.
class KeyframeOctree {
 public:
  // Throws InvalidArgument naming the field.
  explicit KeyframeOctree(const KeyframeOctreeOptions& options = {});
  ~KeyframeOctree();

  // Adds keyframe `id`. It joins the map at once if its id is the largest so far, else with
  // Rebuild(); so does one that replaces the scan of an earlier one. depth and points_C [m] as in
  // OctomapBuilder::Insert(). Throws InvalidArgument as that does.
  void SetKeyframe(std::int64_t id, const cv::Mat& depth, const DepthUnprojector& unprojector,
                   const Pose& T_WC);
  void SetKeyframe(std::int64_t id, std::span<const Eigen::Vector3f> points_C, const Pose& T_WC);
  // Throws InvalidArgument if there is no keyframe `id` or T_WC is not finite.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Does nothing where there is no such keyframe.
  void RemoveKeyframe(std::int64_t id);
  // Hands keyframe `id` over to another octree, of the same resolution, in whose W it stands at
  // T_WC, or there replaces one: its stored scan, to the bit. Both maps wait for Rebuild(). Throws
  // as SetPose(), and InvalidArgument for another resolution.
  void MoveKeyframe(std::int64_t id, const Pose& T_WC, KeyframeOctree& to);

  // Works for `budget` or one keyframe, whichever takes longer, plus, in the last call, the time to
  // put the new region in place. True once the map is right. A pose that changes meanwhile waits
  // for the next round; a keyframe that is removed or replaced starts it again.
  bool Rebuild(std::chrono::duration<double> budget = std::chrono::duration<double>::max());
  // Whether all keyframes are in the map, where their poses want them.
  bool IsCurrent() const;

  const OctomapBuilder& map() const;
  // As OctomapBuilder::SetChangeCallback(); after a round it gets the box of the region.
  void SetChangeCallback(OctomapBuilder::ChangeCallback on_change);
  // Hands the map over and forgets all keyframes.
  OctomapBuilder TakeMap();
  std::size_t KeyframeCount() const;
  // Bytes of the stored scans and lists of bricks.
  std::size_t ScanBytes() const;

 private:
  void RequireKeyframe(std::int64_t id, const Pose& T_WC) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
