#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>

namespace highwall {

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
