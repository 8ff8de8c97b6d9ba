#pragma once

#include <span>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include <highwall/frontend/features/twist.h>
#include "features/depth_grid.h"
#include "sensor/keyframe_row_times.h"

namespace highwall {

// Online estimator of the row times of the images, from the residuals of tracked points alone
// (docs/row_times.md): the read-out of a rolling shutter shears the image of a moving camera, and
// delayed depth does not fit the map. Each frame contributes three equations, with its pose
// eliminated. They are accumulated in an information filter with a memory of a few seconds, because
// the map was built with the previous estimate and adapts to the new one.
class FrameTimingEstimator {
 public:
  // A frame with its pose and its matched points.
  struct View {
    Stamp stamp;
    const FrameFeatures& features;
    std::span<const PointId> points;  // per point feature, kNoId where unmatched
    Pose T_WC;
  };

  // known: initial value. model, grid, keyframes: must outlive it; grid as the features'
  // depth_grid.
  FrameTimingEstimator(const FrameTiming& known, const MeasurementModel& model,
                       const DepthGrid& grid, const KeyframeRowTimes& keyframes);

  // Adds a frame, its features moved to the middle row by timing(), and the motion of the camera at
  // it. A frame backwards in time is ignored.
  void Add(const View& view, const Map& map, const Twist& motion);

  // The timing to be applied: each parameter keeps its known value until the estimate differs
  // significantly from it.
  const FrameTiming& timing() const { return timing_; }
  FrameTimingEstimate estimate() const;

 private:
  using Vector = Eigen::Vector3d;  // colour read-out, depth read-out, delay of depth [s]
  using Matrix = Eigen::Matrix3d;

  // Normal equations in (pose, timing) of one frame.
  struct Equations {
    Eigen::Matrix<double, 9, 9> H = Eigen::Matrix<double, 9, 9>::Zero();
    Eigen::Matrix<double, 9, 1> g = Eigen::Matrix<double, 9, 1>::Zero();
    int points = 0;
  };
  // Dependence of a landmark on the timing that its keyframes were made with.
  struct Landmark {
    Matrix shift = Matrix::Zero();                    // dp_W [m] by each parameter [s]
    Eigen::Vector3d since = Eigen::Vector3d::Zero();  // [m] by the change of the timing since
  };
  // Returns the derivative of a point observed in C by each of the three parameters [m/s].
  Matrix Shift(const PointFeature& feature, const cv::Mat& depth_grid, const Twist& motion) const;
  Landmark ShiftOf(const MapPoint& point, const Map& map) const;
  void AddPoint(const PointFeature& feature, const MapPoint& point, const View& view,
                const Map& map, const Twist& motion, Equations* equations) const;
  Matrix Covariance() const;

  const MeasurementModel& model_;
  PinholeCamera camera_;  // without distortion
  const DepthGrid& grid_;
  Vector known_, estimate_;
  FrameTiming timing_;                   // the estimate where significantly different
  Matrix information_ = Matrix::Zero();  // of the frames, with older ones faded out
  const KeyframeRowTimes& keyframes_;
  Stamp last_ = 0;
};

}  // namespace highwall
