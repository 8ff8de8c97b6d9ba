#pragma once

#include <Eigen/Core>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "features/depth_grid.h"
#include <highwall/frontend/features/twist.h>
#include "tracking/keyframe_row_times.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// When the rows of the images are taken, found out from the residuals of tracked points alone
// (docs/row_times.md): a read-out shears the image of a camera that moves, depth that is late does
// not fit the map. Each frame gives three equations, its pose eliminated; they are added up as an
// information filter of some seconds, for the map has been made with what was believed before, and
// follows.
class FrameTimingEstimator {
 public:
  // known: where it begins. model, grid, keyframes: must outlive it; grid as the features'
  // depth_grid.
  FrameTimingEstimator(const FrameTiming& known, const MeasurementModel& model,
                       const DepthGrid& grid, const KeyframeRowTimes& keyframes);

  // A frame with its matches and pose, features moved to the middle row by timing(), and the motion
  // of the camera at it. Backwards in time nothing happens.
  void Add(const TrackedFrame& tracked, const Map& map, const Twist& motion);

  // What to go by: each is as it was known until frames tell it to be another.
  const FrameTiming& timing() const { return timing_; }
  FrameTimingEstimate estimate() const;

 private:
  using Vector = Eigen::Vector3d;  // colour read-out, depth read-out, delay of depth [s]
  using Matrix = Eigen::Matrix3d;

  // Least squares in (pose, timing) of one frame.
  struct Equations {
    Eigen::Matrix<double, 9, 9> H = Eigen::Matrix<double, 9, 9>::Zero();
    Eigen::Matrix<double, 9, 1> g = Eigen::Matrix<double, 9, 1>::Zero();
    int points = 0;
  };
  // What a landmark has taken on of the timing that its keyframes were made with.
  struct Landmark {
    Matrix shift = Matrix::Zero();                    // of p_W [m] by each of the three, a second
    Eigen::Vector3d since = Eigen::Vector3d::Zero();  // [m] by what was learnt since
  };
  // By how much a point observed in C moves with each of the three [m/s].
  Matrix Shift(const PointFeature& feature, const cv::Mat& depth_grid, const Twist& motion) const;
  Landmark ShiftOf(const MapPoint& point, const Map& map) const;
  void AddPoint(const PointFeature& feature, const MapPoint& point, const TrackedFrame& tracked,
                const Map& map, const Twist& motion, Equations* equations) const;
  Matrix Covariance() const;

  const MeasurementModel& model_;
  PinholeCamera camera_;  // without distortion
  const DepthGrid& grid_;
  Vector known_, estimate_;
  FrameTiming timing_;                   // the estimate where it is told from what is known
  Matrix information_ = Matrix::Zero();  // that the frames gave, the older the less
  const KeyframeRowTimes& keyframes_;
  Stamp last_ = 0;
};

}  // namespace highwall
