#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

namespace highwall::simulate {

// The image that a camera takes while it moves: each pixel averages the sharp image of the middle
// of the exposure along the way that the surface it shows goes across the image meanwhile.
class MotionBlur {
 public:
  explicit MotionBlur(const PinholeCamera& camera);

  // bgr: CV_32FC3, depth: CV_32FC1 [m], 0 = infinitely far; both at the middle of the exposure.
  // T_MB, T_ME: the camera at the beginning and the end, in its frame at the middle.
  // threads: 0 = one per processor; the result does not depend on it.
  cv::Mat Apply(const cv::Mat& bgr, const cv::Mat& depth, const Pose& T_MB, const Pose& T_ME,
                int threads = 0) const;

 private:
  PinholeCamera camera_;
  std::vector<cv::Vec2f> rays_;  // (x/z, y/z) of every pixel, distortion removed
};

}  // namespace highwall::simulate
