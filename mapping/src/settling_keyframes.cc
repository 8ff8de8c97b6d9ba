#include <highwall/mapping/dense_mapper.h>

#include <utility>

#include <highwall/core/error.h>

namespace highwall {
namespace {

// Masks out the depth where `moving` is not 0, in a copy, since the pixels are shared.
void LeaveOut(const cv::Mat& moving, KeyframeImage& keyframe) {
  if (moving.empty()) return;
  keyframe.depth = keyframe.depth.clone();
  keyframe.depth.setTo(0.0, moving);
}

}  // namespace

SettlingKeyframes::SettlingKeyframes(DenseMapper& mapper, SettledKeyframeOf settled, double wait)
    : mapper_(mapper), settled_(std::move(settled)) {
  HIGHWALL_REQUIRE(settled_ != nullptr, "SettlingKeyframes must know whom to ask");
  HIGHWALL_REQUIRE(wait >= 0.0, "the wait of SettlingKeyframes must not be negative");
  wait_ = FromSeconds(wait);
}

void SettlingKeyframes::Add(KeyframeImage keyframe, const cv::Mat& moving) {
  waiting_.push_back(std::move(keyframe));
  LeaveOut(moving, waiting_.back());
}

void SettlingKeyframes::Remove(std::int64_t id) {
  if (std::erase_if(waiting_, [id](const KeyframeImage& k) { return k.id == id; }) == 0) {
    mapper_.RemoveKeyframe(id);
  }
}

void SettlingKeyframes::HandOver(Stamp now) {
  while (!waiting_.empty() && now - waiting_.front().stamp >= wait_) {
    HandOver(waiting_.front());
    waiting_.pop_front();
  }
}

void SettlingKeyframes::HandOverAll() {
  for (KeyframeImage& keyframe : waiting_) HandOver(keyframe);
  waiting_.clear();
}

void SettlingKeyframes::HandOver(KeyframeImage& keyframe) {
  const std::optional<SettledKeyframe> now = settled_(keyframe.id);
  if (!now) return;
  LeaveOut(now->moving, keyframe);
  keyframe.T_WC = now->pose.T_WC;
  keyframe.layer = now->pose.layer;
  mapper_.AddKeyframe(keyframe);
}

}  // namespace highwall
