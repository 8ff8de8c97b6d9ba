#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/pose/pose_uncertainty.h>

#include "ros/ros_types.h"

namespace highwall::apps {

// Returns the covariance of a pose in its map at the origin of the camera, along the axes of the
// world. It is never zero, as where a map begins, because zeros mean an unknown covariance in ROS.
PoseCovariance InWorld(const PoseUncertainty& uncertainty, const Pose& T_WC);

// Returns the covariance of a pose at another point of the same body. lever: [m] from the one to
// the other, along the axes of the covariance.
PoseCovariance MovedBy(const Eigen::Vector3d& lever, const PoseCovariance& covariance);

// Returns the same covariance along other axes. R: to these axes.
PoseCovariance Rotated(const Eigen::Matrix3d& R, const PoseCovariance& covariance);

}  // namespace highwall::apps
