#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>

#include <highwall/frontend/features/twist.h>
#include "features/depth_grid.h"

namespace highwall {

// Rolling-shutter compensation: each row of an image has its own time, as the camera moves during
// the read-out (docs/row_times.md). The time of an image is that of its middle row.

// [-0.5, 0.5] inside the image: delay of row v relative to the middle, as a share of the read-out.
inline double RowTime(double v, int height) {
  return v / height - 0.5;
}

// The same of the row of the sensor that pixel uv belongs to.
inline double RowTime(const Eigen::Vector2d& uv, const PinholeCamera& camera,
                      ReadoutDirection direction) {
  switch (direction) {
    case ReadoutDirection::kDown:
      break;
    case ReadoutDirection::kUp:
      return RowTime(camera.height - 1 - uv.y(), camera.height);
    case ReadoutDirection::kRight:
      return RowTime(uv.x(), camera.width);
    case ReadoutDirection::kLeft:
      return RowTime(camera.width - 1 - uv.x(), camera.width);
  }
  return RowTime(uv.y(), camera.height);
}

// Returns the depth image that the sensor would have measured `delay` + RowTime * readout [s]
// earlier, to first order in the motion, each reading from the nearest pixel. depth: CV_32FC1 [m]
// of the camera's size, else throws InvalidArgument; camera: its distortion is ignored.
cv::Mat DepthAtTime(const cv::Mat& depth, const PinholeCamera& camera, const Twist& motion,
                    double delay, double readout,
                    ReadoutDirection direction = ReadoutDirection::kDown);

// Rate [m/s] at which the depth reading in the pixel of p_C changes while the camera moves,
// including the slope of the surface. depth_grid: of the frame, as DepthGrid::Sample(). Empty at an
// edge.
std::optional<double> DepthRate(const cv::Mat& depth_grid, const DepthGrid& grid,
                                const Eigen::Vector3d& p_C, const Twist& motion);

// Moves the features of an image that was read out over `readout` [s] to where they would have been
// observed at the time of the middle row, with their depth: an observation at its own time
// constrains the camera pose moved by its twist, and vice versa. Features without depth move as if
// at the mean inverse depth of the others, or far away if there is none. camera: without
// distortion.
std::shared_ptr<const FrameFeatures> CompensatedToMiddleRow(
    const FrameFeatures& features, const PinholeCamera& camera, double readout, const Twist& motion,
    ReadoutDirection direction = ReadoutDirection::kDown);

// Timing and motion by which the rows of an image were compensated.
struct RowMotion {
  FrameTiming timing;  // including the delay by the stamp of its depth image
  Twist motion;

  // [s] by which a reading is later than the colour of its pixel. row_time: its RowTime().
  double DepthLate(double row_time) const {
    return timing.depth_delay + (timing.depth_readout - timing.colour_readout) * row_time;
  }
};

// Returns whether two compensations differ by more than a tenth of a pixel anywhere, which is a
// tenth of a corner's noise. depth: [m] of the scene.
bool Differ(const RowMotion& a, const RowMotion& b, const PinholeCamera& camera, double depth);

// Median depth [m] of the points of an image; infinite if none has depth.
double MedianDepth(const FrameFeatures& features);

// Converts features that were compensated by CompensatedToMiddleRow and DepthAtTime with `assumed`
// to another motion and timing. grid: of their depth.
std::shared_ptr<const FrameFeatures> MovedOtherwise(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthGrid& grid, const RowMotion& assumed,
                                                    const RowMotion& found);

}  // namespace highwall
