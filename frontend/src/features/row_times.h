#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>

#include "features/depth_grid.h"
#include <highwall/frontend/features/twist.h>

namespace highwall {

// Images whose rows are of one time each, as a camera moves on while they are read out
// (docs/row_times.md). The time of an image is that of its middle row.

// [-0.5, 0.5] inside the image: the share of the read-out by which row v is later than the middle.
inline double RowTime(double v, int height) {
  return v / height - 0.5;
}

// A depth image, as the sensor would have measured it `delay` + RowTime(v) * readout [s] earlier,
// to first order in the motion meanwhile, each reading from the nearest pixel. depth: CV_32FC1 [m]
// of the camera's size, else throws InvalidArgument; camera: its distortion is not counted.
cv::Mat DepthAtTime(const cv::Mat& depth, const PinholeCamera& camera, const Twist& motion,
                    double delay, double readout);

// [m/s] at which the reading of depth in the pixel of p_C changes while the camera moves, the slope
// of the surface included. depth_grid: of the frame, as DepthGrid::Sample(). Nothing at an edge.
std::optional<double> DepthRate(const cv::Mat& depth_grid, const DepthGrid& grid,
                                const Eigen::Vector3d& p_C, const Twist& motion);

// Features of an image that was read out over `readout` [s], moved to where they would have been
// seen at the time of the middle row, with their depth: an observation at its own time is one of
// the camera's pose moved by its twist, and the other way round. Those without depth move as one at
// the others' mean inverse depth, far away where there is none. camera: without distortion.
std::shared_ptr<const FrameFeatures> AtMiddleRow(const FrameFeatures& features,
                                                 const PinholeCamera& camera, double readout,
                                                 const Twist& motion);

// What the rows of an image were moved by.
struct RowMotion {
  FrameTiming timing;  // the stamp of its depth image counted in
  Twist motion;

  // [s] by which the reading in row v is later than what its pixel is of.
  double DepthLate(double v, int height) const {
    return timing.depth_delay + (timing.depth_readout - timing.colour_readout) * RowTime(v, height);
  }
};

// Whether two such differ by more than a tenth of a pixel anywhere, which is a tenth of a corner's
// noise. depth: [m] of the scene.
bool Differ(const RowMotion& a, const RowMotion& b, const PinholeCamera& camera, double depth);

// [m] of the points of an image; infinite where none has depth.
double MedianDepth(const FrameFeatures& features);

// What AtMiddleRow makes of features whose depth is that of DepthAtTime, both as `assumed`, as
// another motion and timing would have moved them. grid: of their depth.
std::shared_ptr<const FrameFeatures> MovedOtherwise(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthGrid& grid, const RowMotion& assumed,
                                                    const RowMotion& found);

}  // namespace highwall
