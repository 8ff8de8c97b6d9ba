#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// [s] by which the stamp of its depth is later; 0 where it is so far off that the motion of the
// camera meanwhile is not known, or of another clock.
double DepthDelay(const RgbdImage& image);

// What is known of a depth image beyond what RgbdSensor says: how its readings are off over the
// image, and when its rows were read while the camera moved (docs/row_times.md).
struct DepthCorrection {
  DepthPattern pattern{};
  FrameTiming timing{};  // the stamp of the depth image counted in
  Twist motion{};        // of the camera

  bool IsIdentity() const;
  // The depth without the pattern, each reading at the time of its pixel; `depth` itself where
  // nothing is to be corrected. depth: CV_32FC1 [m] of the camera's size, else throws
  // InvalidArgument. camera: its distortion is not counted.
  cv::Mat Apply(const cv::Mat& depth, const PinholeCamera& camera) const;

 private:
  bool MovesRows() const;
};

}  // namespace highwall
