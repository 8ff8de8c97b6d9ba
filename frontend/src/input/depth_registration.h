#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Registers depth images of a camera of their own to the colour camera: each reading is moved to
// where the colour camera sees it, and of several the nearest is kept. Pixels that no reading falls
// on stay holes. Where depth pixels are larger than those of colour, values between the readings of
// one surface are interpolated; nothing is interpolated between two surfaces.
class DepthRegistration {
 public:
  // colour: with its size and distortion. Throws InvalidArgument if either camera is not valid.
  DepthRegistration(const PinholeCamera& colour, const DepthCameraCalibration& depth);

  // depth: CV_32FC1 [m], of the size of the depth camera, else throws InvalidArgument. Returns the
  // depth along the axis of the colour camera [m], of its size; 0 without a reading. noise_factor:
  // RgbdImage's, of the pixels of depth; becomes that of the pixels that are returned, by the
  // reading that each is from, 1 without one. Null or empty: there is none. May be called from
  // several threads.
  cv::Mat Register(const cv::Mat& depth, cv::Mat* noise_factor = nullptr) const;

 private:
  // A reading as the colour camera sees it.
  struct Seen {
    float u = 0.0F, v = 0.0F;  // [px]
    float z = 0.0F;            // [m], 0: none
  };

  // Pixels of the colour camera. reading: CV_32SC1, the index of the reading of each pixel, -1:
  // none; empty unless it is asked for.
  struct Registered {
    cv::Mat depth, reading{};
  };

  std::vector<Seen> Project(const cv::Mat& depth) const;
  void Splat(const std::vector<Seen>& seen, Registered* registered) const;
  void Interpolate(const std::vector<Seen>& seen, Registered* registered) const;

  PinholeCamera colour_;
  float reach_ = 0.0F;                   // SquaredReach() of colour
  int columns_ = 0, rows_ = 0;           // of the depth images
  std::vector<Eigen::Vector3f> rays_C_;  // at z = 1 of the depth camera, turned to C
  Eigen::Vector3f p_CD_;
  float half_width_ = 0.5F, half_height_ = 0.5F;  // [px of colour] half a pixel of depth
};

}  // namespace highwall
