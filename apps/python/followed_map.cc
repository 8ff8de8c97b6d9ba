#include "followed_map.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <highwall/frontend/map/map.h>

namespace highwall::python {
namespace {

// Submaps that are not merged have separate layers.
KeyframePose LayeredPose(const KeyFrame& keyframe, const Map& map) {
  return {keyframe.T_WC, map.Root(keyframe.submap).value()};
}

std::map<std::int64_t, KeyframePose> LayeredPoses(const Map& map) {
  std::map<std::int64_t, KeyframePose> poses;
  for (const KeyFrameId id : map.keyframe_ids()) {
    poses[id.value()] = LayeredPose(*map.keyframe(id), map);
  }
  return poses;
}

// Same condition as in `highwall slam`, which must produce the same map.
bool MovesKeyframes(const FrameResult& frame) {
  return (frame.inertial && frame.inertial->T_level) || frame.drops_submap ||
         (frame.factors && frame.factors->accepted) ||
         std::ranges::any_of(frame.loops, &LoopReport::accepted);
}

}  // namespace

FollowedMap::FollowedMap(const DenseMapOptions& options, const DepthCamera& camera,
                         const SlamSystem& slam, double wait, std::shared_ptr<Reference> system)
    : mapper_(options, camera), system_(std::move(system)) {
  const auto settled = [&slam](std::int64_t id) -> std::optional<SettledKeyframe> {
    const KeyFrame* const keyframe = slam.map().keyframe(KeyFrameId(id));
    if (keyframe == nullptr) return std::nullopt;
    return SettledKeyframe{LayeredPose(*keyframe, slam.map()), slam.MovingIn(keyframe->id)};
  };
  settling_.emplace(mapper_, settled, wait);
}

void FollowedMap::SetKeyframe(const SlamSystem& slam, const KeyFrame& keyframe,
                              const RgbdImage& image, const RgbdImage& original) {
  if (finished_) return;
  Settle({});  // a keyframe without its frame, because another callback raised an exception
  keyframe_ = {keyframe.id.value(), image.stamp, image.depth, image.bgr, keyframe.T_WC};
  originals_[keyframe.id] = {original, slam.depth_pattern()};
}

void FollowedMap::Follow(const SlamSystem& slam, const FrameResult& frame) {
  if (finished_) return;
  Settle(frame.mapping ? frame.moving : cv::Mat());
  if (frame.mapping) {
    for (const KeyFrameId culled : frame.mapping->culled_keyframes) {
      settling_->Remove(culled.value());
      originals_.erase(culled);
    }
  }
  if (MovesKeyframes(frame)) mapper_.SetPoses(LayeredPoses(slam.map()));
  settling_->HandOver(frame.stamp);  // with current poses
}

std::vector<DenseMap> FollowedMap::Finish(const SlamSystem* slam) {
  finished_ = true;
  std::vector<std::int32_t> order;
  if (slam != nullptr) {
    Settle({});
    settling_->HandOverAll();
    MapAgain(*slam);
    mapper_.SetPoses(LayeredPoses(slam->map()));
    for (const SubmapTrajectory& submap : slam->submaps()) order.push_back(submap.submap.value());
  }
  std::map<std::int32_t, DenseMap> layers = mapper_.Finish();
  std::vector<DenseMap> maps;
  for (const std::int32_t layer : order) {
    if (auto map = layers.extract(layer)) maps.push_back(std::move(map.mapped()));
  }
  for (auto& [layer, map] : layers) maps.push_back(std::move(map));
  return maps;
}

void FollowedMap::MapAgain(const SlamSystem& slam) {
  for (const auto& [id, original] : std::exchange(originals_, {})) {
    const KeyFrame* const keyframe = slam.map().keyframe(id);
    if (keyframe == nullptr || original.known.nodes == slam.depth_pattern().nodes) continue;
    const cv::Mat depth = slam.CorrectedDepth(id, original.image.depth);
    settling_->Add({id.value(), original.image.stamp, depth, original.image.bgr, keyframe->T_WC},
                   {});
    settling_->HandOverAll();
  }
}

void FollowedMap::Settle(const cv::Mat& moving) {
  if (keyframe_) settling_->Add(*std::exchange(keyframe_, std::nullopt), moving);
}

}  // namespace highwall::python
