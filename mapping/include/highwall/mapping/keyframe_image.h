#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/mapping/depth_smoothing.h>

namespace highwall {

// An RGB-D camera as mapping knows it: depth is registered to colour, one pinhole for both.
struct DepthCamera {
  PinholeCamera pinhole{};
  DepthSigma sigma;  // of its depth; must not be empty
};

// A posed image of an RGB-D camera; both images have its size.
struct KeyframeImage {
  std::int64_t id = 0;
  Stamp stamp = 0;
  cv::Mat depth;  // CV_32FC1 [m], 0 where nothing was measured
  cv::Mat bgr;    // CV_8UC3
  Pose T_WC;
  std::int32_t layer = 0;
};

// Where a keyframe is: in the world of its layer. Keyframes that nothing ties together yet are in
// layers of their own, each of which has a map of its own.
struct KeyframePose {
  Pose T_WC;
  std::int32_t layer = 0;
};

}  // namespace highwall
