#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

namespace highwall::simulate {

// Camera poses at the beginning and the end of an exposure, relative to its middle.
struct ExposureMotion {
  Pose T_MB, T_ME;
};

// Motion blur: each pixel averages the sharp image of the middle of the exposure along the image
// path of the surface point that it shows.
class MotionBlur {
 public:
  explicit MotionBlur(const PinholeCamera& camera);

  // bgr: CV_32FC3, depth: CV_32FC1 [m], 0 = infinite; both at the middle of the exposure. threads:
  // 0 = one per processor; the result does not depend on it.
  cv::Mat Apply(const cv::Mat& bgr, const cv::Mat& depth, const ExposureMotion& motion,
                int threads = 0) const;
  // With a rolling shutter, every row has its own middle of the exposure and motion about it.
  // Throws InvalidArgument unless there is one per row.
  cv::Mat Apply(const cv::Mat& bgr, const cv::Mat& depth,
                std::span<const ExposureMotion> motion_of_row, int threads = 0) const;

 private:
  PinholeCamera camera_;
  std::vector<cv::Vec2f> rays_;  // (x/z, y/z) of every pixel, distortion removed
};

}  // namespace highwall::simulate
