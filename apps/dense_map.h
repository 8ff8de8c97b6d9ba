#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/depth_unprojector.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/keyframe_octree.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>

namespace highwall::apps {

struct DenseMapOptions {
  KeyframeCloudOptions cloud{.max_depth = 4.0};
  OctomapBuilderOptions octree;
  OccupancyGridOptions grid;  // its R_GW and ground height are estimated
  bool level = false;         // z of W points up, as it does with an IMU
};

struct DenseMap {
  std::vector<ColoredPoint> cloud;
  OctomapBuilder octree;
  OccupancyGrid grid;
  Eigen::Quaterniond R_GW = Eigen::Quaterniond::Identity();  // to the frame of the grid, z up
  std::optional<double> ground_height;                       // [m] in G
  double merge_ms = 0.0, octree_ms = 0.0;
};

// Estimates up and the ground, and fills grid, R_GW and ground_height. cameras: T_WC of those that
// saw the map, at least one. level: z of W points up (a sensor with IMU, a surveyed trajectory);
// else a plane is fitted below the cameras.
void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense);

// The dense map of a run: follows its keyframes.
class DenseMapper {
 public:
  // Throws InvalidArgument.
  DenseMapper(const DenseMapOptions& options, const PinholeCamera& camera);

  void AddKeyframe(std::int64_t id, const cv::Mat& depth, const cv::Mat& bgr, const Pose& T_WC);
  void RemoveKeyframe(std::int64_t id);
  // Does nothing where there is no such keyframe.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Puts everything in place. Call once.
  DenseMap Finish();

 private:
  DenseMapOptions options_;
  DepthUnprojector unprojector_;
  DenseCloud cloud_;
  KeyframeOctree octree_;
  std::map<std::int64_t, Pose> poses_;
};

}  // namespace highwall::apps
