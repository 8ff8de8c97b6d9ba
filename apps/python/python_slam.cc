#include "python_slam.h"

#include <highwall/core/error.h>

namespace highwall::python {

FrameResult PythonSlam::TrackImage(const RgbdImage& image) {
  image_ = image;
  return Track(image);
}

void PythonSlam::Listen(SlamCallbacks callbacks) {
  listener_ = std::move(callbacks);
  Connect();
}

void PythonSlam::AddMapper(const std::shared_ptr<Mapper>& mapper) {
  HIGHWALL_REQUIRE(
      map().keyframe_ids().empty(),
      "a DenseMapper follows a system from its first frame on: make it before track()");
  mappers_.push_back(mapper);
  Connect();
}

void PythonSlam::Connect() {
  SlamCallbacks callbacks = listener_;
  if (!mappers_.empty()) {
    callbacks.on_keyframe = [this](const KeyFrame& keyframe, const RgbdImage& image) {
      ForEachMapper([&](FollowedMap& map) { map.SetKeyframe(*this, keyframe, image_); });
      if (listener_.on_keyframe) listener_.on_keyframe(keyframe, image);
    };
    callbacks.on_keyframes = [this](const KeyframeEvent& event) {
      ForEachMapper([&](FollowedMap& map) { map.Apply(event); });
    };
  }
  SetCallbacks(std::move(callbacks));
}

}  // namespace highwall::python
