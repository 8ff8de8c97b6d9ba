#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

namespace highwall::simulate {

// The camera at the beginning and at the end of an exposure, in its frame at the middle.
struct ExposureMotion {
  Pose T_MB, T_ME;
};

// The image that a camera takes while it moves: each pixel averages the sharp image of the middle
// of the exposure along the way that the surface it shows goes across the image meanwhile.
class MotionBlur {
 public:
  explicit MotionBlur(const PinholeCamera& camera);

  // bgr: CV_32FC3, depth: CV_32FC1 [m], 0 = infinitely far; both at the middle of the exposure.
  // threads: 0 = one per processor; the result does not depend on it.
  cv::Mat Apply(const cv::Mat& bgr, const cv::Mat& depth, const ExposureMotion& motion,
                int threads = 0) const;
  // A rolling shutter: every row has a middle of its own, and a motion about it. Throws
  // InvalidArgument unless there is one per row.
  cv::Mat Apply(const cv::Mat& bgr, const cv::Mat& depth,
                std::span<const ExposureMotion> motion_of_row, int threads = 0) const;

 private:
  PinholeCamera camera_;
  std::vector<cv::Vec2f> rays_;  // (x/z, y/z) of every pixel, distortion removed
};

}  // namespace highwall::simulate
