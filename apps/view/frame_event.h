#pragma once

#include <cstddef>
#include <string>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/frontend/system/slam_system.h>

#include "run/run_observer.h"

namespace highwall::apps {

// Numbers of the map at a frame.
struct MapNumbers {
  std::size_t keyframes = 0, points = 0, lines = 0, submaps = 0;
  std::size_t loops = 0, refused = 0, merges = 0;
};

// What the page shows of the current frame. Its images are shared.
struct FramePicture {
  FrameResult result;
  cv::Mat bgr;
  RunPosition position;
  MapNumbers map;
  double seconds = 0.0;  // since the first frame
};

// Returns the data of an event "frame" (docs/view.md): the image as a small JPEG, its features, the
// dynamic mask, and the state of tracking with its reason.
std::string FrameEvent(const FramePicture& picture, const PinholeCamera& camera);

}  // namespace highwall::apps
