#include "ros/pose_covariance.h"

#include <highwall/core/so3.h>

namespace highwall::apps {

PoseCovariance MovedBy(const Eigen::Vector3d& lever, const PoseCovariance& covariance) {
  PoseCovariance J = PoseCovariance::Identity();
  J.topRightCorner<3, 3>() = -so3::Hat(lever);
  return J * covariance * J.transpose();
}

PoseCovariance Rotated(const Eigen::Matrix3d& R, const PoseCovariance& covariance) {
  PoseCovariance J = PoseCovariance::Zero();
  J.topLeftCorner<3, 3>() = R;
  J.bottomRightCorner<3, 3>() = R;
  return J * covariance * J.transpose();
}

PoseCovariance InWorld(const PoseUncertainty& uncertainty, const Pose& T_WC) {
  constexpr double kLeast = 1e-10;  // [m^2, rad^2]
  return Rotated(T_WC.R(), uncertainty.in_map) + kLeast * PoseCovariance::Identity();
}

}  // namespace highwall::apps
