#include "settling_keyframes.h"

#include <highwall/core/stamp.h>

namespace highwall::apps {

SettlingKeyframes::SettlingKeyframes(const SlamSystem& slam, DenseMapper& mapper, double wait)
    : slam_(slam), mapper_(mapper), wait_(FromSeconds(wait)) {}

void SettlingKeyframes::Add(KeyFrameId id, const RgbdImage& image) {
  waiting_.push_back({id, image});
}

void SettlingKeyframes::Remove(KeyFrameId id) {
  if (std::erase_if(waiting_, [id](const Waiting& w) { return w.id == id; }) == 0) {
    mapper_.RemoveKeyframe(id);
  }
}

void SettlingKeyframes::HandOver(Stamp now) {
  while (!waiting_.empty() && now - waiting_.front().image.stamp >= wait_) {
    HandOver(waiting_.front());
    waiting_.pop_front();
  }
}

void SettlingKeyframes::HandOverAll() {
  for (const Waiting& keyframe : waiting_) HandOver(keyframe);
  waiting_.clear();
}

void SettlingKeyframes::HandOver(const Waiting& keyframe) {
  const KeyFrame* const live = slam_.map().keyframe(keyframe.id);
  if (live == nullptr) return;
  RgbdImage image = keyframe.image;
  if (const cv::Mat moving = slam_.MovingIn(keyframe.id); !moving.empty()) {
    image.depth = image.depth.clone();
    image.depth.setTo(0.0, moving);
  }
  mapper_.AddKeyframe(keyframe.id, image, live->T_WC);
}

}  // namespace highwall::apps
