#pragma once

#include <cmath>
#include <cstdint>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>

#include "box_world.h"
#include "features/depth_grid.h"

// Boxes in front of a wall with grey levels painted on them, as seen on a camera's coarse grids.
namespace highwall::testing {

inline const PinholeCamera kGridCamera = RgbdSensor{}.camera;
inline const DepthGrid kGrid(kGridCamera);
// A box on the left, in front of the wall and above the floor: normals along x, y and z.
inline const BoxWorld kBoxes{.boxes = {{{-1.6, -0.5, 2.0}, {-0.6, 1.0, 3.0}}}};

// Returns the grey level of a surface point at p_W; it differs for another phase.
inline double Paint(const Eigen::Vector3d& p_W, double phase) {
  return 120.0 + 50.0 * std::sin(2.1 * p_W.x() + 1.3 * p_W.y() + phase) +
         40.0 * std::sin(3.7 * p_W.y() - 2.9 * p_W.z() + 2.0 * phase) +
         25.0 * std::sin(5.3 * p_W.x() + 4.1 * p_W.z());
}

struct Light {
  double gain = 1.0, offset = 0.0;
  double phase = 0.0;
  double contrast = 1.0;
};

// Returns depth and grey levels of a frame without any corner or line.
inline FrameFeatures SeeGrids(const BoxWorld& world, const Pose& T_WC, const Light& light = {}) {
  FrameFeatures features;
  features.depth_grid = kGrid.Sample(DepthOf(world, kGridCamera, T_WC), 0.3, 8.0);
  features.gray_grid = cv::Mat(features.depth_grid.size(), CV_8UC1);
  for (int v = 0; v < features.gray_grid.rows; ++v) {
    for (int u = 0; u < features.gray_grid.cols; ++u) {
      const float z = features.depth_grid.at<float>(v, u);
      const Eigen::Vector3d p_W = T_WC * (z * kGrid.Ray({u, v})).cast<double>();
      const double grey = 120.0 + light.contrast * (Paint(p_W, light.phase) - 120.0);
      features.gray_grid.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(light.gain * grey + light.offset);
    }
  }
  return features;
}

}  // namespace highwall::testing
