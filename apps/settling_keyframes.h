#pragma once

#include <deque>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/system/slam_system.h>

#include "dense_map.h"

namespace highwall::apps {

// Keyframes on their way to the dense map. Each waits until the frames after it have shown what
// moved in it: that part of its depth stays out of the map.
class SettlingKeyframes {
 public:
  // wait: [s] >= 0. Both must outlive this.
  SettlingKeyframes(const SlamSystem& slam, DenseMapper& mapper, double wait);

  // moving: FrameResult::moving of its frame; empty: nothing.
  void Add(KeyFrameId id, const RgbdImage& image, const cv::Mat& moving);
  void Remove(KeyFrameId id);
  // Hands over those that have waited long enough at `now`.
  void HandOver(Stamp now);
  void HandOverAll();

 private:
  struct Waiting {
    KeyFrameId id = kNoId;
    RgbdImage image;
  };
  void HandOver(Waiting& keyframe);

  const SlamSystem& slam_;
  DenseMapper& mapper_;
  Stamp wait_;
  std::deque<Waiting> waiting_;
};

}  // namespace highwall::apps
