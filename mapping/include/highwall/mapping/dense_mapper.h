#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/keyframe_event.h>
#include <highwall/core/memory_share.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

class RunProfile;

// Dense map built from depth images and their poses.
struct DenseMap {
  std::vector<ColoredPoint> cloud;  // in W
  OctomapBuilder octree;
  OccupancyGrid grid;
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // from W to the grid frame G, z up
  std::optional<double> ground_height;                       // [m] in G
  double merge_ms = 0.0, octree_ms = 0.0;                    // durations of the final work on both
};

// Estimates the up direction and the ground height from the octree, and fills grid, R_GW and
// ground_height. cameras: poses T_WC of those that observed the map, at least one. level: z of W
// points up (a sensor with IMU, a surveyed trajectory); otherwise a plane is fitted below the
// cameras.
void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense);

// Options of DenseMapper.
struct DenseMapOptions {
  KeyframeCloudOptions cloud;
  OctomapBuilderOptions octree;
  OccupancyGridOptions grid;  // R_GW and ground_height are overwritten by estimates
  bool level = false;         // z of W points up, as it does with an IMU
  bool background = true;     // run on a worker thread
  std::size_t backlog = 8;    // >= 1 keyframes that may wait for the worker thread

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Builds the dense map of a run and keeps it consistent with its keyframes on a worker thread.
// There a correction is applied in time slices, between arriving keyframes. Without the worker
// thread every call completes its work before it returns, and the same calls give the same map, bit
// for bit.
//
// Each layer of keyframes has a separate map. The stored data of a keyframe move with it when it
// changes its layer.
//
// An exception on the worker thread is rethrown once, by the next call; the calls queued behind the
// failed one are lost. To be called from one thread at a time.
class DenseMapper {
 public:
  // profile: for the programs of Highwall, see SlamInputs of the front end; null: none; must
  // outlive the mapper. Throws InvalidArgument on bad options or a bad camera.
  DenseMapper(const DenseMapOptions& options, const DepthCamera& camera,
              RunProfile* profile = nullptr);
  ~DenseMapper();

  // Called on the thread that maps, between the keyframes, after the octree of a layer has changed.
  // The octree may be read during the call only. An empty function disables it; set it before the
  // first keyframe.
  using OctreeCallback = std::function<void(std::int32_t layer, const OctomapBuilder& octree)>;
  void SetOctreeCallback(OctreeCallback on_octree);

  // Applies an event of a SLAM system (SlamCallbacks::on_keyframes) by the calls below. Worlds are
  // layers; the depth of dynamic objects is masked out. Throws InvalidArgument for a keyframe
  // without depth, or with a mask of another size or type, and then applies nothing of the event.
  void Apply(const KeyframeEvent& event);

  // Adds a keyframe, in the order of time. It is mapped when the next one arrives, since their
  // depths are compared. Blocks while the backlog is full.
  void AddKeyframe(const KeyframeImage& keyframe);
  void RemoveKeyframe(std::int64_t id);
  // Sets the current poses and layers of all keyframes: those that are missing are removed, unknown
  // ones are ignored. The maps are then updated accordingly.
  void SetPoses(std::map<std::int64_t, KeyframePose> poses);
  // Returns whether the maps reflect all calls of SetPoses().
  bool IsCurrent() const;
  // Waits for the calls before and returns what the maps hold in memory.
  std::vector<MemoryShare> memory();
  // Completes all work and returns the map of each layer that has keyframes. Must be the last call,
  // and called once.
  std::map<std::int32_t, DenseMap> Finish();
  // After Finish(): processing time of each keyframe [ms] for filters, cloud and octree.
  const std::vector<double>& keyframe_ms() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
