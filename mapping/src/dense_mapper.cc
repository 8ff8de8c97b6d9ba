#include <highwall/mapping/dense_mapper.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/background_worker.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/internal/stopwatch.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/depth_filter.h>
#include <highwall/mapping/keyframe_octree.h>
#include <opencv2/core.hpp>

namespace highwall {
namespace {

using Seconds = std::chrono::duration<double>;

// Time slice of a correction while keyframes arrive: less than the processing time of a keyframe.
constexpr Seconds kSlice(0.02);

void Validate(const KeyframeView& view) {
  const std::string of = " of keyframe " + std::to_string(view.id);
  HIGHWALL_REQUIRE(view.depth, "DenseMapper::Apply: there is no depth" + of);
  const bool masked = view.dynamic && !view.dynamic->empty();
  HIGHWALL_REQUIRE(
      !masked || (view.dynamic->type() == CV_8UC1 && view.dynamic->size() == view.depth->size()),
      "DenseMapper::Apply: the dynamic mask" + of +
          " is no CV_8UC1 image of the size of the depth");
  const auto& factor = view.noise_factor;
  HIGHWALL_REQUIRE(!factor || factor->empty() ||
                       (factor->type() == CV_32FC1 && factor->size() == view.depth->size()),
                   "DenseMapper::Apply: the noise factor" + of +
                       " is no CV_32FC1 image of the size of the depth");
}

// Its pixels are not this mapper's to change.
KeyframeImage WithoutDynamicObjects(const KeyframeView& view) {
  KeyframeImage image{.id = view.id,
                      .stamp = view.stamp,
                      .depth = *view.depth,
                      .bgr = view.bgr ? *view.bgr : cv::Mat(),
                      .T_WC = view.place.T_WC,
                      .layer = view.place.world,
                      .noise_factor = view.noise_factor ? *view.noise_factor : cv::Mat()};
  if (view.dynamic && !view.dynamic->empty()) {
    image.depth = image.depth.clone();
    image.depth.setTo(0.0, *view.dynamic);
  }
  return image;
}

}  // namespace

void DenseMapOptions::Validate() const {
  cloud.Validate();
  octree.Validate();
  grid.Validate();
  HIGHWALL_REQUIRE(backlog >= 1, "DenseMapOptions::backlog must be at least 1");
}

struct DenseMapper::Impl {
  struct Layer {
    explicit Layer(const DenseMapOptions& options)
        : cloud({.voxel_size = options.cloud.voxel_size}), octree(options.octree) {}

    DenseCloud cloud;
    KeyframeOctree octree;
  };

  Impl(const DenseMapOptions& of_map, const DepthCamera& camera, RunProfile* run)
      : profile(run),
        options((of_map.Validate(), of_map)),
        unprojector(camera.pinhole),
        filter(camera, options.cloud.voxel_size) {
    if (!options.background) return;
    worker.emplace(
        options.backlog, [this] { return Follow(kSlice); },
        ThreadLabel{"dense mapping", profile, ThreadPriority::kBackground});
  }

  // Runs `work` on the worker's thread, or here if there is no worker.
  void Post(std::function<void()> work) {
    if (worker) {
      worker->Post([work = std::move(work)](const std::stop_token&) { work(); });
      return;
    }
    work();
    Follow(Seconds::max());
  }
  Layer& LayerOf(std::int32_t id) { return layers.try_emplace(id, options).first->second; }
  void Map(const KeyframeImage& keyframe);
  void Remove(std::int64_t id);
  void Move(const std::map<std::int64_t, KeyframePose>& poses);
  // Returns true while work is left.
  bool Follow(Seconds budget);
  DenseMap Take(std::int32_t id, Layer& layer) const;

  RunProfile* const profile;
  const DenseMapOptions options;
  const DepthUnprojector unprojector;
  DepthFilter filter;
  OctreeCallback on_octree;
  std::map<std::int32_t, Layer> layers;         // layers that have keyframes
  std::map<std::int64_t, KeyframePose> mapped;  // poses of the keyframes in the layers
  std::vector<double> keyframe_ms;
  int requested = 0;                       // number of calls of SetPoses()
  int known = 0;                           // number of them processed by the worker
  std::atomic<int> followed = 0;           // number of them reflected by the maps
  std::optional<BackgroundWorker> worker;  // last, so that it is destroyed before what it uses
};

void DenseMapper::Impl::Map(const KeyframeImage& keyframe) {
  const std::vector<ColoredPoint> points =
      MakeKeyframeCloud(keyframe.depth, keyframe.bgr, unprojector, options.cloud);
  std::vector<Eigen::Vector3f> points_C;
  points_C.reserve(points.size());
  for (const ColoredPoint& point : points) points_C.push_back(point.p);
  const auto before = mapped.find(keyframe.id);
  if (before != mapped.end() && before->second.layer != keyframe.layer) Remove(keyframe.id);
  Layer& layer = LayerOf(keyframe.layer);
  layer.cloud.SetKeyframe(keyframe.id, points);
  layer.cloud.SetPose(keyframe.id, keyframe.T_WC);
  layer.octree.SetKeyframe(keyframe.id, points_C, keyframe.T_WC);
  mapped[keyframe.id] = {keyframe.T_WC, keyframe.layer};
  if (on_octree) on_octree(keyframe.layer, layer.octree.map());
}

void DenseMapper::Impl::Remove(std::int64_t id) {
  const auto keyframe = mapped.find(id);
  if (keyframe == mapped.end()) return;
  const auto layer = layers.find(keyframe->second.layer);
  layer->second.cloud.RemoveKeyframe(id);
  layer->second.octree.RemoveKeyframe(id);
  if (layer->second.octree.KeyframeCount() == 0) layers.erase(layer);
  mapped.erase(keyframe);
}

void DenseMapper::Impl::Move(const std::map<std::int64_t, KeyframePose>& poses) {
  const StageTimer timer(profile, "moved keyframes");
  filter.SetPoses(poses);
  std::vector<std::int64_t> gone;
  for (auto& [id, pose] : mapped) {
    const auto now = poses.find(id);
    if (now == poses.end()) {
      gone.push_back(id);
      continue;
    }
    Layer& layer = layers.at(pose.layer);
    if (now->second.layer == pose.layer) {
      layer.cloud.SetPose(id, now->second.T_WC);
      layer.octree.SetPose(id, now->second.T_WC);
    } else {
      Layer& to = LayerOf(now->second.layer);
      layer.cloud.MoveKeyframe(id, now->second.T_WC, to.cloud);
      layer.octree.MoveKeyframe(id, now->second.T_WC, to.octree);
    }
    pose = now->second;
  }
  for (const std::int64_t id : gone) Remove(id);
  std::erase_if(layers, [](const auto& entry) { return entry.second.octree.KeyframeCount() == 0; });
  ++known;
}

bool DenseMapper::Impl::Follow(Seconds budget) {
  if (followed == known) return false;
  const StageTimer timer(profile, "moved map");
  const Stopwatch stopwatch;
  const auto left = [&] { return budget - Seconds(stopwatch.Seconds()); };
  // The octrees are updated first, since a robot plans with them.
  for (auto& [id, layer] : layers) {
    if (!layer.octree.Rebuild(left())) return true;
  }
  for (auto& [id, layer] : layers) {
    if (!layer.cloud.Rebuild(left())) return true;
  }
  followed = known;
  if (on_octree) {
    for (const auto& [id, layer] : layers) on_octree(id, layer.octree.map());
  }
  return false;
}

DenseMap DenseMapper::Impl::Take(std::int32_t id, Layer& layer) const {
  DenseMap dense;
  {
    const StageTimer timer(profile, "octree", &dense.octree_ms);
    layer.octree.Rebuild();
    dense.octree = layer.octree.TakeMap();
  }
  {
    const StageTimer timer(profile, "cloud", &dense.merge_ms);
    dense.cloud = layer.cloud.TakeMerged();
  }
  std::vector<Pose> cameras;
  for (const auto& [keyframe, pose] : mapped) {
    if (pose.layer == id) cameras.push_back(pose.T_WC);
  }
  AddGrid(cameras, options.level, options.grid, dense);
  return dense;
}

DenseMapper::DenseMapper(const DenseMapOptions& options, const DepthCamera& camera,
                         RunProfile* profile)
    : impl_(std::make_unique<Impl>(options, camera, profile)) {}

DenseMapper::~DenseMapper() = default;

void DenseMapper::SetOctreeCallback(OctreeCallback on_octree) {
  impl_->on_octree = std::move(on_octree);
}

void DenseMapper::Apply(const KeyframeEvent& event) {
  for (const KeyframeView& view : event.added) Validate(view);
  for (const std::int64_t id : event.removed) RemoveKeyframe(id);
  if (event.places) {
    std::map<std::int64_t, KeyframePose> poses;
    for (const auto& [id, place] : *event.places) poses[id] = {place.T_WC, place.world};
    SetPoses(std::move(poses));
  }
  for (const KeyframeView& view : event.added) AddKeyframe(WithoutDynamicObjects(view));
}

void DenseMapper::AddKeyframe(const KeyframeImage& keyframe) {
  impl_->Post([&impl = *impl_, keyframe] {
    double milliseconds = 0.0;
    StageTimer timer(impl.profile, "keyframe", &milliseconds);
    if (const auto ready = impl.filter.Push(keyframe)) impl.Map(*ready);
    timer.Stop();
    impl.keyframe_ms.push_back(milliseconds);
  });
}

void DenseMapper::RemoveKeyframe(std::int64_t id) {
  impl_->Post([&impl = *impl_, id] {
    impl.filter.Remove(id);
    impl.Remove(id);
  });
}

void DenseMapper::SetPoses(std::map<std::int64_t, KeyframePose> poses) {
  ++impl_->requested;
  impl_->Post([&impl = *impl_, poses = std::move(poses)] { impl.Move(poses); });
}

bool DenseMapper::IsCurrent() const {
  return impl_->followed == impl_->requested;
}

std::vector<MemoryShare> DenseMapper::memory() {
  std::size_t cloud = 0, scans = 0, octree = 0, images = 0;
  // On the thread of the worker, which otherwise continues to move the maps.
  impl_->Post([&] {
    for (const auto& [id, layer] : impl_->layers) {
      cloud += layer.cloud.MemoryBytes();
      scans += layer.octree.ScanBytes();
      octree += layer.octree.map().MemoryBytes();
    }
    images = impl_->filter.MemoryBytes();
  });
  if (impl_->worker) impl_->worker->Wait();
  return {{"cloud", cloud},
          {"scans of the octree", scans},
          {"octree", octree},
          {"images of the newest keyframes", images}};
}

std::map<std::int32_t, DenseMap> DenseMapper::Finish() {
  impl_->Post([&impl = *impl_] {
    if (const auto last = impl.filter.Flush()) impl.Map(*last);
  });
  if (impl_->worker) impl_->worker->Finish();
  std::map<std::int32_t, DenseMap> maps;
  for (auto& [id, layer] : impl_->layers) maps.emplace(id, impl_->Take(id, layer));
  return maps;
}

const std::vector<double>& DenseMapper::keyframe_ms() const {
  return impl_->keyframe_ms;
}

}  // namespace highwall
