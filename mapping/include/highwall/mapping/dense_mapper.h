#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// What is made of depth images and their poses.
struct DenseMap {
  std::vector<ColoredPoint> cloud;  // in W
  OctomapBuilder octree;
  OccupancyGrid grid;
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // to the frame of the grid, z up
  std::optional<double> ground_height;                       // [m] in G
  double merge_ms = 0.0, octree_ms = 0.0;                    // what both took in the end
};

// Estimates up and the ground from the octree, and fills grid, R_GW and ground_height. cameras:
// T_WC of those that saw the map, at least one. level: z of W points up (a sensor with IMU, a
// surveyed trajectory); else a plane is fitted below the cameras.
void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense);

// Of DenseMapper.
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

// [s] Long enough for something that moves to have left its place.
inline constexpr double kSettlingTime = 2.0;

// What is known of a keyframe by the time it has settled.
struct SettledKeyframe {
  KeyframePose pose;
  cv::Mat moving;  // CV_8UC1 of the image's size, not 0 where something moves; empty: nothing does
};

// Empty where the keyframe is no more.
using SettledKeyframeOf = std::function<std::optional<SettledKeyframe>(std::int64_t id)>;

// Keyframes on their way to the dense map. Each waits until the frames after it have shown what
// moved in it: that part of its depth stays out of the map.
class SettlingKeyframes {
 public:
  // mapper: must outlive this. settled: asked when a keyframe is handed over. wait: [s] >= 0, 0:
  // nothing moves. Throws InvalidArgument.
  SettlingKeyframes(DenseMapper& mapper, SettledKeyframeOf settled, double wait = kSettlingTime);

  // In the order of time. moving: what is known by now, as in SettledKeyframe.
  void Add(KeyframeImage keyframe, const cv::Mat& moving);
  // Here, or from the map.
  void Remove(std::int64_t id);
  // Hands over those that have waited long enough at `now`. Throws what DenseMapper::AddKeyframe()
  // does.
  void HandOver(Stamp now);
  void HandOverAll();

 private:
  void HandOver(KeyframeImage& keyframe);

  DenseMapper& mapper_;
  SettledKeyframeOf settled_;
  Stamp wait_;
  std::deque<KeyframeImage> waiting_;
};

}  // namespace highwall
