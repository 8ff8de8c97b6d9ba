#include "dense_stage.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include <highwall/frontend/map/map.h>
#include <highwall/mapping/dense_mapper.h>

#include "attempt.h"
#include "depth_camera.h"

namespace highwall::apps {
namespace {

constexpr const char* kDenseMap = "dense map";

// Whether any of the loops moved keyframes.
bool MovesMap(const std::vector<LoopReport>& reports) {
  return std::ranges::any_of(reports, &LoopReport::accepted);
}

// Submaps that are not merged have separate layers.
KeyframePose PoseInLayer(const KeyFrame& keyframe, const Map& map) {
  return {keyframe.T_WC, map.Root(keyframe.submap).value()};
}

std::map<std::int64_t, KeyframePose> KeyFramePoses(const Map& map) {
  std::map<std::int64_t, KeyframePose> poses;
  for (const KeyFrameId id : map.keyframe_ids()) {
    poses[id.value()] = PoseInLayer(*map.keyframe(id), map);
  }
  return poses;
}

}  // namespace

// Passes the keyframes of a run to its dense map.
class DenseStage::KeyframeMapping {
 public:
  KeyframeMapping(const SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
                  const SlamRunOptions& options)
      : slam_(slam),
        dataset_(dataset),
        mapper_(MapOptions(options, sensor), DepthCameraOf(sensor)),
        settling_(
            mapper_, [this](std::int64_t id) { return Settled(KeyFrameId(id)); },
            options.slam.tracker.moving.enabled ? kSettlingTime : 0.0) {}

  // Sets the keyframe of the frame passed to the next Follow(), and its image with corrected depth,
  // as in SlamCallbacks.
  void SetKeyframe(const KeyFrame& keyframe, const RgbdImage& image) {
    keyframe_ = {keyframe.id.value(), image.stamp, image.depth, image.bgr, keyframe.T_WC};
    made_with_[keyframe.id] = {image.stamp, slam_.depth_pattern()};
  }
  void Follow(const FrameResult& result) {
    if (result.mapping && keyframe_) {
      settling_.Add(*std::exchange(keyframe_, std::nullopt), result.moving);
      for (const KeyFrameId culled : result.mapping->culled_keyframes) {
        settling_.Remove(culled.value());
        made_with_.erase(culled);
      }
    }
    const bool levelled = result.inertial && result.inertial->T_level;
    const bool follows_gps = result.factors && result.factors->accepted;
    if (levelled || result.drops_submap || follows_gps || MovesMap(result.loops)) {
      mapper_.SetPoses(KeyFramePoses(slam_.map()));
    }
    settling_.HandOver(result.stamp);  // with current poses
  }

  // Stores the dense map of each submap.
  void Finish(SlamRun* run) {
    settling_.HandOverAll();
    MapAgain();
    mapper_.SetPoses(KeyFramePoses(slam_.map()));
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
    return map;
  }
  std::optional<SettledKeyframe> Settled(KeyFrameId id) const {
    const KeyFrame* const live = slam_.map().keyframe(id);
    if (live == nullptr) return std::nullopt;
    return SettledKeyframe{PoseInLayer(*live, slam_.map()), slam_.MovingIn(id)};
  }
  // Maps keyframes again, from their images, that were created before the depth distortion was
  // known. Their stamps ascend, as those of the dataset do.
  void MapAgain() {
    const DepthPattern pattern = slam_.depth_pattern();
    auto next = made_with_.begin();
    for (std::size_t i = 0; i < dataset_.size() && next != made_with_.end(); ++i) {
      if (dataset_.stamp(i) != next->second.stamp) continue;
      const auto& [id, made_with] = *next++;
      if (made_with.pattern.nodes != pattern.nodes) MapAgain(id, i);
    }
  }
  void MapAgain(KeyFrameId id, std::size_t frame) {
    const KeyFrame* const live = slam_.map().keyframe(id);
    const std::optional<RgbdImage> image = live ? dataset_.Load(frame) : std::nullopt;
    if (!image) return;
    const cv::Mat depth = slam_.CorrectedDepth(id, image->depth);
    settling_.Add({id.value(), image->stamp, depth, image->bgr, live->T_WC}, {});
    settling_.HandOverAll();
  }

  const SlamSystem& slam_;
  const Dataset& dataset_;
  DenseMapper mapper_;
  SettlingKeyframes settling_;
  std::optional<KeyframeImage> keyframe_;
  std::map<KeyFrameId, MadeWith> made_with_;
};

DenseStage::DenseStage(SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
                       const SlamRunOptions& options) {
  if (!options.dense) return;
  mapping_ = std::make_unique<KeyframeMapping>(slam, dataset, sensor, options);
  slam.SetCallbacks({.on_keyframe = [this](const KeyFrame& keyframe, const RgbdImage& image) {
    if (mapping_) mapping_->SetKeyframe(keyframe, image);
  }});
}

DenseStage::~DenseStage() = default;

void DenseStage::Follow(const FrameResult& result) {
  if (!mapping_) return;
  if (!Attempt(kDenseMap, &failures_, [&] { mapping_->Follow(result); })) mapping_.reset();
}

void DenseStage::Finish(SlamRun* run) {
  if (mapping_) Attempt(kDenseMap, &failures_, [&] { mapping_->Finish(run); });
  for (std::string& failure : failures_) run->failures.push_back(std::move(failure));
}

}  // namespace highwall::apps
