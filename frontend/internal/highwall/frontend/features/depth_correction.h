#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// Correction of a depth image beyond the RgbdSensor model: the depth distortion over the image, and
// the rolling-shutter compensation for a moving camera (docs/row_times.md).
struct DepthCorrection {
  DepthPattern pattern{};
  FrameTiming timing{};  // including the delay by the stamp of the depth image
  Twist motion{};        // of the camera

  bool IsIdentity() const;
  // Returns the depth without the pattern, each reading at the time of its pixel; `depth` itself if
  // nothing has to be corrected. depth: CV_32FC1 [m] of the camera's size, else throws
  // InvalidArgument. camera: its distortion is ignored.
  cv::Mat Apply(const cv::Mat& depth, const PinholeCamera& camera) const;

 private:
  bool MovesRows() const;
};

}  // namespace highwall
