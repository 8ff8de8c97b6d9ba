#include "dense_map.h"

#include <chrono>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>
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

DenseMapper::DenseMapper(const DenseMapOptions& options, const RgbdSensor& sensor)
    : options_(options),
      unprojector_(sensor.camera),
      filter_(sensor, options.cloud.voxel_size),
      cloud_({.voxel_size = options.cloud.voxel_size}),
      octree_({.octree = options.octree}) {
  options.cloud.Validate();
  options.grid.Validate();
  HIGHWALL_REQUIRE(options.backlog >= 1, "DenseMapOptions::backlog must be at least 1");
  if (!options.background) return;
  constexpr std::chrono::duration<double> kSlice(0.02);
  worker_.emplace(options.backlog, [this, kSlice] { return Follow(kSlice); });
}

void DenseMapper::Post(std::function<void()> work) {
  if (worker_) return worker_->Post(std::move(work));
  work();
  Follow(std::chrono::duration<double>::max());
}

void DenseMapper::AddKeyframe(std::int64_t id, const RgbdImage& image, const Pose& T_WC) {
  Post([this, id, image, T_WC] {
    const auto start = Clock::now();
    if (const auto ready = filter_.Push({id, image, T_WC})) Map(*ready);
    keyframe_ms_.push_back(MillisecondsSince(start));
  });
}

void DenseMapper::Map(const PosedImage& keyframe) {
  const std::vector<ColoredPoint> cloud =
      MakeKeyframeCloud(keyframe.image.depth, keyframe.image.bgr, unprojector_, options_.cloud);
  std::vector<Eigen::Vector3f> points_C;
  points_C.reserve(cloud.size());
  for (const ColoredPoint& point : cloud) points_C.push_back(point.p);
  cloud_.SetKeyframe(keyframe.id, cloud);
  cloud_.SetPose(keyframe.id, keyframe.T_WC);
  octree_.SetKeyframe(keyframe.id, points_C, keyframe.T_WC);
  poses_[keyframe.id] = keyframe.T_WC;
}

void DenseMapper::RemoveKeyframe(std::int64_t id) {
  Post([this, id] {
    filter_.Remove(id);
    cloud_.RemoveKeyframe(id);
    octree_.RemoveKeyframe(id);
    poses_.erase(id);
  });
}

void DenseMapper::SetPoses(std::map<std::int64_t, Pose> poses) {
  ++requested_;
  Post([this, poses = std::move(poses)] {
    for (const auto& [id, T_WC] : poses) {
      filter_.SetPose(id, T_WC);
      if (!poses_.contains(id)) continue;
      cloud_.SetPose(id, T_WC);
      octree_.SetPose(id, T_WC);
      poses_[id] = T_WC;
    }
    ++known_;
  });
}

bool DenseMapper::Follow(std::chrono::duration<double> budget) {
  if (followed_ == known_) return false;
  // First what a robot plans with.
  const bool done = octree_.Rebuild(budget) && cloud_.Rebuild(budget);
  if (done) followed_ = known_;
  return !done;
}

DenseMap DenseMapper::Finish() {
  Post([this] {
    if (const auto last = filter_.Flush()) Map(*last);
  });
  if (worker_) worker_->Finish();
  DenseMap dense;
  dense.keyframe_ms = keyframe_ms_;
  const auto octree_start = Clock::now();
  octree_.Rebuild();
  dense.octree = octree_.TakeMap();
  dense.octree_ms = MillisecondsSince(octree_start);
  const auto merge_start = Clock::now();
  dense.cloud = cloud_.TakeMerged();
  dense.merge_ms = MillisecondsSince(merge_start);
  std::vector<Pose> cameras;
  for (const auto& [id, T_WC] : poses_) cameras.push_back(T_WC);
  AddGrid(cameras, options_.level, options_.grid, dense);
  return dense;
}

}  // namespace highwall::apps
