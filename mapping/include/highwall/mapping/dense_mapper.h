#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/mapping/dense_map.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/keyframe_image.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>

namespace highwall {

struct DenseMapOptions {
  KeyframeCloudOptions cloud;
  OctomapBuilderOptions octree;
  OccupancyGridOptions grid;  // its R_GW and ground height are estimated
  bool level = false;         // z of W points up, as it does with an IMU
  bool background = true;     // on a thread of its own
  std::size_t backlog = 8;    // >= 1 keyframes that may wait for that thread

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The dense map of a run: follows its keyframes, on a thread of its own. There a correction is put
// in place a slice of time at once, between the keyframes that arrive. Without that thread every
// call does its work before it returns, and the same calls give the same map, bit for bit.
//
// Each layer of keyframes has a map of its own, with nothing of another. A keyframe that changes
// its layer takes along what is stored of it.
//
// What goes wrong on that thread is thrown by the next call, once; the calls that waited behind it
// are lost. To be called from one thread at a time.
class DenseMapper {
 public:
  // Throws InvalidArgument.
  DenseMapper(const DenseMapOptions& options, const DepthCamera& camera);
  ~DenseMapper();

  // Keyframes in the order of time; one is mapped when the next one comes, whose depth it is
  // compared with. Waits where the backlog is full.
  void AddKeyframe(const KeyframeImage& keyframe);
  void RemoveKeyframe(std::int64_t id);
  // Where the keyframes are now, and in which layers: all of them, for those that are missing are
  // removed. Unknown ones are passed over. The maps follow.
  void SetPoses(std::map<std::int64_t, KeyframePose> poses);
  // Whether the maps have followed all SetPoses().
  bool IsCurrent() const;
  // Puts everything in place: the map of each layer that has keyframes. Call once, last.
  std::map<std::int32_t, DenseMap> Finish();
  // After Finish(): what each keyframe took [ms], filters, cloud and octree.
  const std::vector<double>& keyframe_ms() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
