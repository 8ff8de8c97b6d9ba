#include "dense_map.h"

#include <chrono>
#include <cmath>
#include <utility>

#include <highwall/mapping/ground_plane.h>
#include <highwall/mapping/map_comparison.h>

namespace highwall::apps {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense) {
  Eigen::Vector3d camera_up_W = Eigen::Vector3d::Zero(), viewpoint_W = Eigen::Vector3d::Zero();
  for (const Pose& T_WC : cameras) {
    camera_up_W -= T_WC.R().col(1);
    viewpoint_W += T_WC.p() / static_cast<double>(cameras.size());
  }
  OccupancyGridOptions grid = options;
  if (!level && !camera_up_W.isZero(1e-6)) {
    const auto plane =
        FitGroundPlane(OccupiedCentres(dense.octree), camera_up_W, viewpoint_W,
                       {.max_tilt = 60.0, .thickness = dense.octree.options().resolution});
    grid.R_GW = UprightRotation(plane ? plane->up_W : camera_up_W);
  }
  dense.R_GW = grid.R_GW;
  dense.ground_height = FloorHeight(dense.octree, grid.R_GW);
  if (dense.ground_height) grid.ground_height = *dense.ground_height;
  dense.grid = ProjectToGrid(dense.octree, grid);
}

DenseMapper::DenseMapper(const DenseMapOptions& options, const PinholeCamera& camera)
    : options_(options),
      unprojector_(camera),
      cloud_({.voxel_size = options.cloud.voxel_size}),
      octree_({.octree = options.octree}) {
  options.cloud.Validate();
  options.grid.Validate();
}

void DenseMapper::AddKeyframe(std::int64_t id, const cv::Mat& depth, const cv::Mat& bgr,
                              const Pose& T_WC) {
  const std::vector<ColoredPoint> cloud =
      MakeKeyframeCloud(depth, bgr, unprojector_, options_.cloud);
  std::vector<Eigen::Vector3f> points_C;
  points_C.reserve(cloud.size());
  for (const ColoredPoint& point : cloud) points_C.push_back(point.p);
  cloud_.SetKeyframe(id, cloud);
  cloud_.SetPose(id, T_WC);
  octree_.SetKeyframe(id, points_C, T_WC);
  poses_[id] = T_WC;
}

void DenseMapper::RemoveKeyframe(std::int64_t id) {
  cloud_.RemoveKeyframe(id);
  octree_.RemoveKeyframe(id);
  poses_.erase(id);
}

void DenseMapper::SetPose(std::int64_t id, const Pose& T_WC) {
  if (!poses_.contains(id)) return;
  cloud_.SetPose(id, T_WC);
  octree_.SetPose(id, T_WC);
  poses_[id] = T_WC;
}

DenseMap DenseMapper::Finish() {
  DenseMap dense;
  const auto merge_start = Clock::now();
  cloud_.Rebuild();
  dense.cloud = cloud_.Merged();
  dense.merge_ms = MillisecondsSince(merge_start);
  const auto octree_start = Clock::now();
  octree_.Rebuild();
  dense.octree = octree_.TakeMap();
  dense.octree_ms = MillisecondsSince(octree_start);
  std::vector<Pose> cameras;
  for (const auto& [id, T_WC] : poses_) cameras.push_back(T_WC);
  AddGrid(cameras, options_.level, options_.grid, dense);
  return dense;
}

}  // namespace highwall::apps
