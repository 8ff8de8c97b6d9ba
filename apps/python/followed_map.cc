#include "followed_map.h"

#include <cstdint>
#include <utility>

#include <highwall/frontend/map/map.h>

namespace highwall::python {

void FollowedMap::SetKeyframe(const SlamSystem& slam, const KeyFrame& keyframe,
                              const RgbdImage& original) {
  if (!finished_) originals_[keyframe.id] = {original, slam.sensor().depth_pattern};
}

void FollowedMap::Apply(const KeyframeEvent& event) {
  if (finished_) return;
  for (const std::int64_t id : event.removed) originals_.erase(KeyFrameId(id));
  mapper_.Apply(event);
}

std::vector<DenseMap> FollowedMap::Finish(const SlamSystem* slam) {
  std::vector<std::int32_t> order;
  if (slam != nullptr) {
    Apply(slam->waiting_keyframes());
    MapAgain(*slam);
    for (const SubmapTrajectory& submap : slam->submaps()) order.push_back(submap.submap.value());
  }
  finished_ = true;
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
    if (original.known.nodes == slam.sensor().depth_pattern.nodes) continue;
    if (const auto view = slam.keyframe_view(id, original.image)) mapper_.Apply({.added = {*view}});
  }
}

}  // namespace highwall::python
