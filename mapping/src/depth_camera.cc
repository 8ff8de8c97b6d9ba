#include <highwall/mapping/depth_camera.h>

#include <string>

#include <highwall/core/error.h>

namespace highwall {

DepthUnprojector::DepthUnprojector(const PinholeCamera& camera)
    : width_(camera.width), height_(camera.height) {
  camera.Validate();
  const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  x_.reserve(pixels);
  y_.reserve(pixels);
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const Eigen::Vector3d ray = camera.Unproject({u, v}, 1.0);
      x_.push_back(static_cast<float>(ray.x()));
      y_.push_back(static_cast<float>(ray.y()));
    }
  }
}

void DepthUnprojector::RequireDepth(const cv::Mat& depth) const {
  if (depth.empty()) return;
  HIGHWALL_REQUIRE(depth.type() == CV_32FC1, "a depth image is CV_32FC1, in metres");
  HIGHWALL_REQUIRE(depth.cols == width_ && depth.rows == height_,
                   "the depth image is " + std::to_string(depth.cols) + " x " +
                       std::to_string(depth.rows) + ", the camera " + std::to_string(width_) +
                       " x " + std::to_string(height_));
}

}  // namespace highwall
