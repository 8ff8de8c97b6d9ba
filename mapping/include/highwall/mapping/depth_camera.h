#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// Default maximum depth [m] used for mapping: a D435i has a noise of 14 cm there.
inline constexpr double kDenseRange = 6.0;

// Standard deviation [m] of a measured depth [m].
using DepthSigma = std::function<double(double z)>;

// RGB-D camera model of the mapping module: depth is registered to colour, with one pinhole model
// for both.
struct DepthCamera {
  PinholeCamera pinhole{};
  DepthSigma sigma;  // standard deviation of the depth; must not be empty
};

// RGB-D image with its pose; both images have the size of the camera.
struct KeyframeImage {
  std::int64_t id = 0;
  Stamp stamp = 0;
  cv::Mat depth;  // CV_32FC1 [m], 0 where nothing was measured
  cv::Mat bgr;    // CV_8UC3
  Pose T_WC;
  std::int32_t layer = 0;
  // CV_32FC1 of the size of depth: factor on DepthCamera::sigma, > 0 where there is depth;
  // empty: 1.
  cv::Mat noise_factor{};
};

// Pose of a keyframe in the world of its layer. Keyframes that are not connected yet are in
// separate layers, each of which has a separate map.
struct KeyframePose {
  Pose T_WC;
  std::int32_t layer = 0;
};

// Ray table of a camera: one undistorted direction (x/z, y/z) per pixel, computed once, so that
// unprojecting a pixel costs two multiplications whatever the distortion (docs/equations.md,
// section 6: x = m_x z, y = m_y z).
class DepthUnprojector {
 public:
  // Throws InvalidArgument if the camera is not valid.
  explicit DepthUnprojector(const PinholeCamera& camera);

  int width() const { return width_; }
  int height() const { return height_; }

  // Return x/z and y/z of the pixels of row v, width() of each; 0 <= v < height() is not checked.
  const float* RowX(int v) const { return x_.data() + static_cast<std::ptrdiff_t>(v) * width_; }
  const float* RowY(int v) const { return y_.data() + static_cast<std::ptrdiff_t>(v) * width_; }
  // Returns the point p_C [m] at depth z [m] of pixel (u, v) inside of the image (not checked).
  Eigen::Vector3f Unproject(int u, int v, float z) const {
    return {RowX(v)[u] * z, RowY(v)[u] * z, z};
  }

  // Throws InvalidArgument unless `depth` is empty or CV_32FC1 of the size of the camera.
  void RequireDepth(const cv::Mat& depth) const;

 private:
  int width_;
  int height_;
  std::vector<float> x_, y_;
};

}  // namespace highwall
