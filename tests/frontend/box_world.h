#pragma once

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>

// Exact depth images of boxes in front of a wall and above a floor: W has x right, y down, z
// forward.
namespace highwall::testing {

struct Box {
  Eigen::Vector3d low, high;  // [m]

  Box MovedBy(const Eigen::Vector3d& shift) const { return {low + shift, high + shift}; }
};

struct BoxWorld {
  double wall = 4.0;   // [m] z of the wall
  double floor = 1.0;  // [m] y of the floor
  std::vector<Box> boxes;
};

// Returns the distance along the ray p + t d to a box; infinite if the ray misses it.
inline double Hit(const Box& box, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.low(i) - p(i)) / d(i), b = (box.high(i) - p(i)) / d(i);
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave ? enter : std::numeric_limits<double>::infinity();
}

// Returns the depth image, CV_32FC1 [m], of a camera inside the room.
inline cv::Mat DepthOf(const BoxWorld& world, const PinholeCamera& camera, const Pose& T_WC) {
  cv::Mat depth(camera.height, camera.width, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      // With z = 1 along the ray, the distance is the depth.
      const Eigen::Vector3d d = T_WC.R() * camera.Unproject({u, v}, 1.0);
      double z = (world.wall - T_WC.p().z()) / d.z();
      if (d.y() > 0.0) z = std::min(z, (world.floor - T_WC.p().y()) / d.y());
      for (const Box& box : world.boxes) z = std::min(z, Hit(box, T_WC.p(), d));
      depth.at<float>(v, u) = static_cast<float>(z);
    }
  }
  return depth;
}

inline void AddNoise(const DepthNoise& noise, std::mt19937& rng, cv::Mat& depth) {
  std::normal_distribution<double> normal;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      float& z = depth.at<float>(v, u);
      z += static_cast<float>(noise.Sigma(static_cast<double>(z)) * normal(rng));
    }
  }
}

}  // namespace highwall::testing
