#pragma once

#include <highwall/core/pose.h>

#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate {

// Spline trajectory with an optional start at rest: the camera is stationary, accelerates within a
// second, and then follows the spline at its normal speed. Twice continuously differentiable.
class CameraPath {
 public:
  // rest [s] >= 0: stationary time; 0: the unmodified spline, in motion from the beginning. Throws
  // InvalidArgument.
  CameraPath(SplineTrajectory spline, double rest);

  // t [s] of the recording, from the first frame on; any.
  Pose T_WC(double t) const;
  CameraMotion MotionAt(double t) const;

  // Position along the spline, in seconds of the spline, and its derivatives: the speed is 0 at
  // rest and 1 later.
  struct Progress {
    double s = 0.0;    // [s]
    double ds = 1.0;   // [1]
    double dds = 0.0;  // [1/s]
  };
  Progress ProgressAt(double t) const;

  // Returns the part of `duration` [s] that remains for the spline, without rest and start.
  static double MovingTime(double duration, double rest);

 private:
  SplineTrajectory spline_;
  double rest_;
};

}  // namespace highwall::simulate
