#include "settling_keyframes.h"

#include <highwall/core/stamp.h>

namespace highwall::apps {
namespace {

// Takes the depth where `moving` is not 0 off an image; its pixels belong to others as well.
void LeaveOut(const cv::Mat& moving, RgbdImage& image) {
  if (moving.empty()) return;
  image.depth = image.depth.clone();
  image.depth.setTo(0.0, moving);
}

}  // namespace

SettlingKeyframes::SettlingKeyframes(const SlamSystem& slam, DenseMapper& mapper, double wait)
    : slam_(slam), mapper_(mapper), wait_(FromSeconds(wait)) {}

void SettlingKeyframes::Add(KeyFrameId id, const RgbdImage& image, const cv::Mat& moving) {
  waiting_.push_back({id, image});
  LeaveOut(moving, waiting_.back().image);
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
  for (Waiting& keyframe : waiting_) HandOver(keyframe);
  waiting_.clear();
}

void SettlingKeyframes::HandOver(Waiting& keyframe) {
  const KeyFrame* const live = slam_.map().keyframe(keyframe.id);
  if (live == nullptr) return;
  LeaveOut(slam_.MovingIn(keyframe.id), keyframe.image);
  mapper_.AddKeyframe(keyframe.id, keyframe.image, live->T_WC);
}

}  // namespace highwall::apps
