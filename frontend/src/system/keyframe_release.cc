#include "system/keyframe_release.h"

#include <memory>

#include <opencv2/core.hpp>

#include "features/memory_bytes.h"

namespace highwall {
namespace {

// Dynamic where either mask says so.
cv::Mat Union(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return a | b;
}

std::shared_ptr<const cv::Mat> Shared(const cv::Mat& image) {
  return std::make_shared<const cv::Mat>(image);
}

}  // namespace

KeyframePlace PlaceOf(const KeyFrame& keyframe, const Map& map) {
  return {keyframe.T_WC, map.Root(keyframe.submap).value()};
}

std::map<std::int64_t, KeyframePlace> PlacesOf(const Map& map) {
  std::map<std::int64_t, KeyframePlace> places;
  for (const KeyFrameId id : map.keyframe_ids()) {
    places[id.value()] = PlaceOf(*map.keyframe(id), map);
  }
  return places;
}

void KeyframeRelease::Add(KeyFrameId id, const RgbdImage& image, const cv::Mat& dynamic) {
  waiting_.push_back({id, image.stamp, image.depth.clone(), image.bgr.clone(), dynamic.clone(),
                      image.noise_factor.clone()});
}

void KeyframeRelease::Remove(KeyFrameId id) {
  std::erase_if(waiting_, [id](const Waiting& waiting) { return waiting.id == id; });
  removed_.push_back(id.value());
}

KeyframeEvent KeyframeRelease::Event(Stamp now, const Map& map, const MaskOf& mask) const {
  KeyframeEvent event{.removed = removed_};
  if (moved_) event.places = PlacesOf(map);
  for (const Waiting& waiting : waiting_) {
    if (!HasWaited(waiting, now)) break;
    AddView(waiting, map, mask, &event.added);
  }
  return event;
}

KeyframeEvent KeyframeRelease::LastEvent(const Map& map, const MaskOf& mask) const {
  KeyframeEvent event{.removed = removed_, .places = PlacesOf(map)};
  for (const Waiting& waiting : waiting_) AddView(waiting, map, mask, &event.added);
  return event;
}

std::size_t KeyframeRelease::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const Waiting& waiting : waiting_) {
    bytes += BytesOf(waiting.depth) + BytesOf(waiting.bgr) + BytesOf(waiting.dynamic) +
             BytesOf(waiting.noise_factor);
  }
  return bytes;
}

void KeyframeRelease::SetEmitted(Stamp now) {
  while (!waiting_.empty() && HasWaited(waiting_.front(), now)) waiting_.pop_front();
  removed_.clear();
  moved_ = false;
}

void KeyframeRelease::SetLastEmitted() {
  waiting_.clear();
  removed_.clear();
  moved_ = false;
}

void KeyframeRelease::AddView(const Waiting& waiting, const Map& map, const MaskOf& mask,
                              std::vector<KeyframeView>* views) {
  const KeyFrame* const keyframe = map.keyframe(waiting.id);
  if (keyframe == nullptr) return;
  views->push_back({.id = waiting.id.value(),
                    .stamp = waiting.stamp,
                    .depth = Shared(waiting.depth),
                    .bgr = Shared(waiting.bgr),
                    .dynamic = Shared(Union(waiting.dynamic, mask(waiting.id))),
                    .noise_factor = Shared(waiting.noise_factor),
                    .place = PlaceOf(*keyframe, map)});
}

}  // namespace highwall
