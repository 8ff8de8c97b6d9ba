#pragma once

#include <Eigen/Core>

#include <highwall/frontend/system/slam_system.h>

#include "ros/ros_types.h"

namespace highwall::apps {

// Standard deviations that are assumed where the system estimates none.
struct AssumedNoise {
  double position = 0.02;  // [m] > 0
  double rotation = 0.01;  // [rad] > 0
};

// Returns the covariance of the pose of a frame, at the origin of the camera and along the axes of
// the world: with an IMU that of its smoother, else the assumed one, which unobservable directions
// enlarge. T_BC: the camera on the IMU.
PoseCovariance CovarianceOf(const FrameResult& result, const Pose& T_BC, const AssumedNoise& noise);

// Returns the covariance of a pose at another point of the same body. lever: [m] from the one to
// the other, along the axes of the covariance.
PoseCovariance MovedBy(const Eigen::Vector3d& lever, const PoseCovariance& covariance);

// Returns the same covariance along other axes. R: to these axes.
PoseCovariance Rotated(const Eigen::Matrix3d& R, const PoseCovariance& covariance);

}  // namespace highwall::apps
