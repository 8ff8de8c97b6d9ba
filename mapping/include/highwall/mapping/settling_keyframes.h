#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/keyframe_image.h>

namespace highwall {

// [s] Long enough for something that moves to have left its place.
inline constexpr double kSettlingTime = 2.0;

// What is known of a keyframe by the time it has settled.
struct SettledKeyframe {
  KeyframePose pose;
  cv::Mat moving;  // CV_8UC1 of the image's size, not 0 where something moves; empty: nothing does
};

// Empty where the keyframe is no more.
using SettledKeyframeOf = std::function<std::optional<SettledKeyframe>(std::int64_t id)>;

// Keyframes on their way to the dense map. Each waits until the frames after it have shown what
// moved in it: that part of its depth stays out of the map.
class SettlingKeyframes {
 public:
  // mapper: must outlive this. settled: asked when a keyframe is handed over. wait: [s] >= 0, 0:
  // nothing moves. Throws InvalidArgument.
  SettlingKeyframes(DenseMapper& mapper, SettledKeyframeOf settled, double wait = kSettlingTime);

  // In the order of time. moving: what is known by now, as in SettledKeyframe.
  void Add(KeyframeImage keyframe, const cv::Mat& moving);
  // Here, or from the map.
  void Remove(std::int64_t id);
  // Hands over those that have waited long enough at `now`. Throws what DenseMapper::AddKeyframe()
  // does.
  void HandOver(Stamp now);
  void HandOverAll();

 private:
  void HandOver(KeyframeImage& keyframe);

  DenseMapper& mapper_;
  SettledKeyframeOf settled_;
  Stamp wait_;
  std::deque<KeyframeImage> waiting_;
};

}  // namespace highwall
