#include "run/dense_stage.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include <highwall/core/keyframe_event.h>
#include <highwall/frontend/map/map.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/mapping/dense_mapper.h>

#include "cli/attempt.h"
#include "run/depth_camera.h"
#include "run/run_observer.h"

namespace highwall::apps {
namespace {

constexpr const char* kDenseMap = "dense map";

// Number of keyframes, with colour and depth in metres, that 64 MB hold: 29 of 640 x 480.
std::size_t LiveBacklog(const PinholeCamera& camera) {
  constexpr double kBytes = 64e6, kPixel = 7.0;
  const double keyframes = kBytes / (kPixel * camera.width * camera.height);
  return std::max<std::size_t>(8, static_cast<std::size_t>(keyframes));
}

}  // namespace

// Passes the keyframes of a run to its dense map.
class DenseStage::KeyframeMapping {
 public:
  KeyframeMapping(const SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
                  const SlamRunOptions& options, RunProfile* profile)
      : slam_(slam),
        dataset_(dataset),
        profile_(profile),
        mapper_(MapOptions(options, sensor), DepthCameraOf(sensor), profile) {
    if (options.observer == nullptr) return;
    mapper_.SetOctreeCallback(
        [observer = options.observer](std::int32_t world, const OctomapBuilder& octree) {
          observer->OnOctree(world, octree);
        });
  }

  void SetKeyframe(const KeyFrame& keyframe) {
    made_with_[keyframe.id] = {keyframe.frame.stamp, slam_.sensor().depth_pattern};
  }
  void Apply(const KeyframeEvent& event) { mapper_.Apply(event); }

  void Complete() {
    mapper_.Apply(
        slam_.waiting_keyframes());  // only the places, unless SlamSystem::Finish() failed
    MapAgain();
  }

  std::vector<MemoryShare> memory() { return mapper_.memory(); }

  // Stores the dense map of each submap.
  void Finish(SlamRun* run) {
    std::map<std::int32_t, DenseMap> maps = mapper_.Finish();
    const auto take = [&maps](SubmapRun& submap) {
      const auto map = maps.find(submap.submap.value());
      if (map != maps.end()) submap.dense = std::move(map->second);
    };
    take(run->largest);
    for (SubmapRun& submap : run->others) take(submap);
    run->times.dense = Summarize(mapper_.keyframe_ms());
  }

 private:
  struct MadeWith {
    Stamp stamp = 0;
    DepthPattern pattern;
  };

  static DenseMapOptions MapOptions(const SlamRunOptions& options, const RgbdSensor& sensor) {
    DenseMapOptions map = options.map;
    LimitToRange(sensor, &map);
    if (options.imu) map.level = true;
    // Tracking waits for the dense map only if that has fallen behind by so many keyframes.
    if (options.live) map.backlog = LiveBacklog(sensor.camera);
    return map;
  }
  // Maps keyframes again, from their images, that were created before the depth distortion was
  // known. Their stamps ascend, as those of the dataset do.
  void MapAgain() {
    const DepthPattern pattern = slam_.sensor().depth_pattern;
    auto next = made_with_.begin();
    for (std::size_t i = 0; i < dataset_.size() && next != made_with_.end(); ++i) {
      if (dataset_.stamp(i) != next->second.stamp) continue;
      const auto& [id, made_with] = *next++;
      if (made_with.pattern.nodes != pattern.nodes) MapAgain(id, i);
    }
  }
  std::optional<RgbdImage> Load(std::size_t frame) const {
    const DecodingTimer timer(profile_);
    return dataset_.Load(frame);
  }
  void MapAgain(KeyFrameId id, std::size_t frame) {
    if (slam_.map().keyframe(id) == nullptr) return;
    if (const std::optional<RgbdImage> image = Load(frame)) {
      if (const auto view = slam_.keyframe_view(id, *image)) mapper_.Apply({.added = {*view}});
    }
  }

  const SlamSystem& slam_;
  const Dataset& dataset_;
  RunProfile* const profile_;
  DenseMapper mapper_;
  std::map<KeyFrameId, MadeWith> made_with_;
};

DenseStage::DenseStage(const SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
                       const SlamRunOptions& options, RunProfile* profile) {
  if (!options.dense) return;
  mapping_ = std::make_unique<KeyframeMapping>(slam, dataset, sensor, options, profile);
}

DenseStage::~DenseStage() = default;

void DenseStage::AddTo(SlamCallbacks* callbacks) {
  if (!mapping_) return;
  callbacks->on_keyframe = [this](const KeyFrame& keyframe, const RgbdImage&) {
    if (mapping_) mapping_->SetKeyframe(keyframe);
  };
  callbacks->on_keyframes = [this](const KeyframeEvent& event) { Apply(event); };
}

void DenseStage::Apply(const KeyframeEvent& event) {
  if (!mapping_) return;
  if (!Attempt(kDenseMap, &failures_, [&] { mapping_->Apply(event); })) mapping_.reset();
}

std::vector<MemoryShare> DenseStage::memory() {
  std::vector<MemoryShare> shares;
  if (mapping_ && !Attempt(kDenseMap, &failures_, [&] { shares = mapping_->memory(); })) {
    mapping_.reset();
  }
  return shares;
}

void DenseStage::Complete() {
  if (!mapping_) return;
  if (!Attempt(kDenseMap, &failures_, [&] { mapping_->Complete(); })) mapping_.reset();
}

void DenseStage::Finish(SlamRun* run) {
  if (mapping_) Attempt(kDenseMap, &failures_, [&] { mapping_->Finish(run); });
  for (std::string& failure : failures_) run->failures.push_back(std::move(failure));
}

}  // namespace highwall::apps
