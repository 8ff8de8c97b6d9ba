#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/mapping/depth_unprojector.h>
#include <highwall/mapping/octomap_builder.h>

namespace highwall {

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

  // Works for `budget` or one keyframe, whichever takes longer, plus, in the last call, the time to
  // put the new region in place. True once the map is right. A pose that changes meanwhile waits
  // for the next round; a keyframe that is removed or replaced starts it again.
  bool Rebuild(std::chrono::duration<double> budget = std::chrono::duration<double>::max());
  // Whether all keyframes are in the map, where their poses want them.
  bool IsCurrent() const;

  const OctomapBuilder& map() const { return map_; }
  // As OctomapBuilder::SetChangeCallback(); after a round it gets the box of the region.
  void SetChangeCallback(OctomapBuilder::ChangeCallback on_change);
  // Hands the map over and forgets all keyframes.
  OctomapBuilder TakeMap();
  std::size_t KeyframeCount() const { return keyframes_.size(); }
  // Bytes of the stored scans and lists of bricks.
  std::size_t ScanBytes() const;

 private:
  struct Keyframe {
    float quantum = 0.0f;  // [m]
    std::vector<std::array<std::int16_t, 3>> points_C;
    Pose T_WC;                          // where it should be
    std::optional<Pose> T_WC_in_map;    // where the map has it
    std::vector<std::uint64_t> bricks;  // that it touches there, Morton codes, ascending
  };
  struct Round;

  bool HasMoved(const Keyframe& keyframe) const;
  // Gathers the scan of a keyframe in `builder`, and lists its bricks.
  static std::vector<std::uint64_t> Gather(const Keyframe& keyframe, const Pose& T_WC,
                                           OctomapBuilder& builder);
  void StartRound();
  // One keyframe; false when there is nothing left to do but FinishRound().
  bool Step();
  void FinishRound();

  KeyframeOctreeOptions options_;
  OctomapBuilder map_;
  std::map<std::int64_t, Keyframe> keyframes_;
  std::vector<std::uint64_t> orphaned_;  // bricks of scans that are no more
  std::unique_ptr<Round> round_;
};

}  // namespace highwall
