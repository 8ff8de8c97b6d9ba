#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/depth_unprojector.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/keyframe_octree.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>

#include "background_worker.h"
#include "depth_filter.h"

namespace highwall::apps {

struct DenseMapOptions {
  KeyframeCloudOptions cloud{.max_depth = 6.0};
  OctomapBuilderOptions octree{.max_range = 6.0};
  OccupancyGridOptions grid;  // its R_GW and ground height are estimated
  bool level = false;         // z of W points up, as it does with an IMU
  bool background = true;     // on a thread of its own
  std::size_t backlog = 8;    // >= 1 keyframes that may wait for that thread
};

struct DenseMap {
  std::vector<ColoredPoint> cloud;
  OctomapBuilder octree;
  OccupancyGrid grid;
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // to the frame of the grid, z up
  std::optional<double> ground_height;                       // [m] in G
  std::vector<double> keyframe_ms;  // what each keyframe took: filters, cloud and octree
  double merge_ms = 0.0, octree_ms = 0.0;
};

// Estimates up and the ground, and fills grid, R_GW and ground_height. cameras: T_WC of those that
// saw the map, at least one. level: z of W points up (a sensor with IMU, a surveyed trajectory);
// else a plane is fitted below the cameras.
void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense);

// The dense map of a run: follows its keyframes, on a thread of its own. There a correction is put
// in place a slice of time at once, between the keyframes that arrive. Without that thread every
// call does its work before it returns, and the same calls give the same map, bit for bit.
class DenseMapper {
 public:
  // Throws InvalidArgument.
  DenseMapper(const DenseMapOptions& options, const RgbdSensor& sensor);

  // Keyframes in the order of time; one is mapped when the next one comes, whose depth it is
  // compared with. Waits where the backlog is full. Throws what an earlier call met.
  void AddKeyframe(std::int64_t id, const RgbdImage& image, const Pose& T_WC);
  void RemoveKeyframe(std::int64_t id);
  // Where keyframes are now; unknown ones are passed over. The map follows.
  void SetPoses(std::map<std::int64_t, Pose> poses);
  // Whether the map has followed all SetPoses().
  bool IsCurrent() const { return followed_ == requested_; }
  // Puts everything in place. Call once, last.
  DenseMap Finish();

 private:
  // Does `work`, there or here.
  void Post(std::function<void()> work);
  void Map(const PosedImage& keyframe);
  // True while there is more to do.
  bool Follow(std::chrono::duration<double> budget);

  DenseMapOptions options_;
  DepthUnprojector unprojector_;
  DepthFilter filter_;
  DenseCloud cloud_;
  KeyframeOctree octree_;
  std::map<std::int64_t, Pose> poses_;  // of what is mapped
  std::vector<double> keyframe_ms_;
  int requested_ = 0;                       // calls of SetPoses(), and how many of them
  int known_ = 0;                           // the work has come to,
  std::atomic<int> followed_ = 0;           // the map has followed
  std::optional<BackgroundWorker> worker_;  // last, so that it ends before what it uses
};

}  // namespace highwall::apps
