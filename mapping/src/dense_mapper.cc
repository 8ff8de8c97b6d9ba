#include <highwall/mapping/dense_mapper.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/background_worker.h>
#include <highwall/core/error.h>
#include <highwall/core/stopwatch.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/depth_filter.h>
#include <highwall/mapping/depth_unprojector.h>
#include <highwall/mapping/keyframe_octree.h>

namespace highwall {
namespace {

using Seconds = std::chrono::duration<double>;

// What a correction may take at once while keyframes arrive: less than one of them takes.
constexpr Seconds kSlice(0.02);

}  // namespace

void DenseMapOptions::Validate() const {
  cloud.Validate();
  octree.Validate();
  grid.Validate();
  HIGHWALL_REQUIRE(backlog >= 1, "DenseMapOptions::backlog must be at least 1");
}

struct DenseMapper::Impl {
  Impl(const DenseMapOptions& of_map, const DepthCamera& camera)
      : options((of_map.Validate(), of_map)),
        unprojector(camera.pinhole),
        filter(camera, options.cloud.voxel_size),
        cloud({.voxel_size = options.cloud.voxel_size}),
        octree({.octree = options.octree}) {
    if (options.background) worker.emplace(options.backlog, [this] { return Follow(kSlice); });
  }

  // Does `work`, on the worker's thread or here.
  void Post(std::function<void()> work) {
    if (worker) {
      worker->Post([work = std::move(work)](const std::stop_token&) { work(); });
      return;
    }
    work();
    Follow(Seconds::max());
  }
  void Map(const KeyframeImage& keyframe);
  void Move(const std::map<std::int64_t, Pose>& T_WC);
  // True while there is more to do.
  bool Follow(Seconds budget);

  const DenseMapOptions options;
  const DepthUnprojector unprojector;
  DepthFilter filter;
  DenseCloud cloud;
  KeyframeOctree octree;
  std::map<std::int64_t, Pose> poses;  // of what is mapped
  std::vector<double> keyframe_ms;
  int requested = 0;                       // calls of SetPoses(), and how many of them
  int known = 0;                           // the work has come to,
  std::atomic<int> followed = 0;           // the map has followed
  std::optional<BackgroundWorker> worker;  // last, so that it ends before what it uses
};

void DenseMapper::Impl::Map(const KeyframeImage& keyframe) {
  const std::vector<ColoredPoint> points =
      MakeKeyframeCloud(keyframe.depth, keyframe.bgr, unprojector, options.cloud);
  std::vector<Eigen::Vector3f> points_C;
  points_C.reserve(points.size());
  for (const ColoredPoint& point : points) points_C.push_back(point.p);
  cloud.SetKeyframe(keyframe.id, points);
  cloud.SetPose(keyframe.id, keyframe.T_WC);
  octree.SetKeyframe(keyframe.id, points_C, keyframe.T_WC);
  poses[keyframe.id] = keyframe.T_WC;
}

void DenseMapper::Impl::Move(const std::map<std::int64_t, Pose>& T_WC) {
  for (const auto& [id, pose] : T_WC) {
    filter.SetPose(id, pose);
    if (!poses.contains(id)) continue;
    cloud.SetPose(id, pose);
    octree.SetPose(id, pose);
    poses[id] = pose;
  }
  ++known;
}

bool DenseMapper::Impl::Follow(Seconds budget) {
  if (followed == known) return false;
  // First what a robot plans with.
  const bool done = octree.Rebuild(budget) && cloud.Rebuild(budget);
  if (done) followed = known;
  return !done;
}

DenseMapper::DenseMapper(const DenseMapOptions& options, const DepthCamera& camera)
    : impl_(std::make_unique<Impl>(options, camera)) {}

DenseMapper::~DenseMapper() = default;

void DenseMapper::AddKeyframe(const KeyframeImage& keyframe) {
  impl_->Post([&impl = *impl_, keyframe] {
    const Stopwatch stopwatch;
    if (const auto ready = impl.filter.Push(keyframe)) impl.Map(*ready);
    impl.keyframe_ms.push_back(stopwatch.Milliseconds());
  });
}

void DenseMapper::RemoveKeyframe(std::int64_t id) {
  impl_->Post([&impl = *impl_, id] {
    impl.filter.Remove(id);
    impl.cloud.RemoveKeyframe(id);
    impl.octree.RemoveKeyframe(id);
    impl.poses.erase(id);
  });
}

void DenseMapper::SetPoses(std::map<std::int64_t, Pose> T_WC) {
  ++impl_->requested;
  impl_->Post([&impl = *impl_, T_WC = std::move(T_WC)] { impl.Move(T_WC); });
}

bool DenseMapper::IsCurrent() const {
  return impl_->followed == impl_->requested;
}

DenseMap DenseMapper::Finish() {
  impl_->Post([&impl = *impl_] {
    if (const auto last = impl.filter.Flush()) impl.Map(*last);
  });
  if (impl_->worker) impl_->worker->Finish();
  DenseMap dense;
  dense.keyframe_ms = impl_->keyframe_ms;
  const Stopwatch octree;
  impl_->octree.Rebuild();
  dense.octree = impl_->octree.TakeMap();
  dense.octree_ms = octree.Milliseconds();
  const Stopwatch merge;
  dense.cloud = impl_->cloud.TakeMerged();
  dense.merge_ms = merge.Milliseconds();
  std::vector<Pose> cameras;
  for (const auto& [id, T_WC] : impl_->poses) cameras.push_back(T_WC);
  AddGrid(cameras, impl_->options.level, impl_->options.grid, dense);
  return dense;
}

}  // namespace highwall
