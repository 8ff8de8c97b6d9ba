#include "ros/pose_covariance.h"

#include <algorithm>

namespace highwall::apps {
namespace {

constexpr double kUnknown = 100.0;  // [m] standard deviation of a direction without any constraint

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return cross;
}

}  // namespace

PoseCovariance MovedBy(const Eigen::Vector3d& lever, const PoseCovariance& covariance) {
  PoseCovariance J = PoseCovariance::Identity();
  J.topRightCorner<3, 3>() = -Cross(lever);
  return J * covariance * J.transpose();
}

PoseCovariance Rotated(const Eigen::Matrix3d& R, const PoseCovariance& covariance) {
  PoseCovariance J = PoseCovariance::Zero();
  J.topLeftCorner<3, 3>() = R;
  J.bottomRightCorner<3, 3>() = R;
  return J * covariance * J.transpose();
}

PoseCovariance CovarianceOf(const FrameResult& result, const Pose& T_BC,
                            const AssumedNoise& noise) {
  PoseCovariance covariance = PoseCovariance::Identity();
  if (result.inertial && result.inertial->estimate) {
    const InertialEstimate& estimate = *result.inertial->estimate;
    const Eigen::Matrix3d R_WB = result.T_WC.R() * T_BC.R().transpose();
    PoseCovariance to_world = PoseCovariance::Identity();  // position is along the world's axes
    to_world.bottomRightCorner<3, 3>() = R_WB;
    covariance = to_world * estimate.covariance.topLeftCorner<6, 6>() * to_world.transpose();
    return MovedBy(R_WB * T_BC.p(), covariance);
  }
  covariance.diagonal().head<3>().setConstant(noise.position * noise.position);
  covariance.diagonal().tail<3>().setConstant(noise.rotation * noise.rotation);
  const Eigen::Matrix3d R_WC = result.T_WC.R();
  for (const UnobservableDirection& open : result.unobservable_directions) {
    Eigen::Matrix<double, 6, 1> direction;
    direction << R_WC * open.translation_C, R_WC * open.rotation_C;
    const double sigma = std::min(open.sigma, kUnknown);
    covariance += sigma * sigma * direction * direction.transpose();
  }
  return covariance;
}

}  // namespace highwall::apps
