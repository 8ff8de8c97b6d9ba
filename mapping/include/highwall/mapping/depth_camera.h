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

// [m] Depth farther away makes no map, unless options say otherwise: a D435i's noise is 14 cm
// there.
inline constexpr double kDenseRange = 6.0;

// Standard deviation [m] of a measured depth [m].
using DepthSigma = std::function<double(double z)>;

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

// The ray table of a camera: one undistorted direction (x/z, y/z) per pixel, computed once, so that
// the point behind a pixel costs two multiplications (docs/equations.md, section 6: x = m_x z,
// y = m_y z) whatever the distortion.
class DepthUnprojector {
 public:
  // Throws InvalidArgument if the camera is not valid.
  explicit DepthUnprojector(const PinholeCamera& camera);

  int width() const { return width_; }
  int height() const { return height_; }

  // x/z and y/z of the pixels of row v, width() of each; 0 <= v < height() is not checked.
  const float* RowX(int v) const { return x_.data() + static_cast<std::ptrdiff_t>(v) * width_; }
  const float* RowY(int v) const { return y_.data() + static_cast<std::ptrdiff_t>(v) * width_; }
  // The point p_C [m] at depth z [m] behind pixel (u, v) inside the image (not checked).
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
