// Posed images of the inside of a box, for tests of the dense map.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/mapping/depth_camera.h>

namespace highwall {

inline DepthCamera SmallCamera() {
  return {
      .pinhole = {.width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5},
      .sigma = [](double z) { return 0.002 * z * z; }};
}

// Returns the image of the camera at T_WC inside a room from (-2, -1.2, -2) to (2, 0.8, 4) [m], y
// down: exact depth, and one colour per wall.
inline KeyframeImage ViewOfBox(std::int64_t id, double seconds, const Pose& T_WC) {
  const Eigen::Vector3d low(-2.0, -1.2, -2.0), high(2.0, 0.8, 4.0);
  const PinholeCamera camera = SmallCamera().pinhole;
  KeyframeImage image{id, FromSeconds(seconds), cv::Mat(camera.height, camera.width, CV_32FC1),
                      cv::Mat(camera.height, camera.width, CV_8UC3), T_WC};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray_C((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const Eigen::Vector3d ray_W = T_WC.R() * ray_C;
      double z = std::numeric_limits<double>::infinity();
      int wall = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (ray_W[axis] == 0.0) continue;
        const double border = ray_W[axis] > 0.0 ? high[axis] : low[axis];
        const double z_wall = (border - T_WC.p()[axis]) / ray_W[axis];
        if (z_wall < z) wall = 2 * axis + (ray_W[axis] > 0.0 ? 1 : 0);
        z = std::min(z, z_wall);
      }
      image.depth.at<float>(v, u) = static_cast<float>(z);
      const auto grey = static_cast<std::uint8_t>(40 * wall + 20);
      image.bgr.at<cv::Vec3b>(v, u) = {grey, grey, 100};
    }
  }
  return image;
}

// Six keyframes on a path of half a metre, a tenth of a second apart, with ids 0, 2, ..., 10.
inline std::vector<KeyframeImage> WalkThroughBox() {
  std::vector<KeyframeImage> keyframes;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitY()));
    keyframes.push_back(ViewOfBox(2 * i, 0.1 * i, Pose(q, {0.1 * i, 0.02 * i, 0.0})));
  }
  return keyframes;
}

}  // namespace highwall
