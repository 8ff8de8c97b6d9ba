#pragma once

#include <highwall/core/pose.h>

#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate {

// A spline trajectory that may begin at rest: the camera stands still, gathers speed within a
// second, and from then on moves along the spline as it is. Twice continuously differentiable.
class CameraPath {
 public:
  // rest [s] >= 0: how long it stands still; 0: the spline as it is, in motion from the beginning.
  // Throws InvalidArgument.
  CameraPath(SplineTrajectory spline, double rest);

  // t [s] of the recording, from the first frame on; any.
  Pose T_WC(double t) const;
  CameraMotion MotionAt(double t) const;

  // How far along the spline the camera is, in seconds of the spline, and how fast it goes: 0 at
  // rest, 1 later.
  struct Progress {
    double s = 0.0;    // [s]
    double ds = 1.0;   // [1]
    double dds = 0.0;  // [1/s]
  };
  Progress ProgressAt(double t) const;

  // The part of `duration` [s] that is left for the spline: duration without rest and start.
  static double MovingTime(double duration, double rest);

 private:
  SplineTrajectory spline_;
  double rest_;
};

}  // namespace highwall::simulate
