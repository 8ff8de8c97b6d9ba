#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/so3.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/anchored_pose.h>

namespace highwall {

// The pose of a frame as its image states it, in its world: of the camera, or of the body of an
// IMU.
struct MeasuredPose {
  Stamp stamp = 0;
  Pose T_WB;
  std::optional<ImageInformation> information{};      // as in PosedFrame, in B
  std::shared_ptr<const ReadingsBetween> readings{};  // since the pose before
  KeyFrameId reference = kNoId;                       // to which its image was anchored
};

// The velocity of that body.
struct BodyVelocity {
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();                                // [m/s]
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();                             // [rad/s]
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  // of both
};

// A pose after smoothing over time.
struct SmoothedPose {
  Pose T_WB;
  std::optional<BodyVelocity> velocity{};  // if it is determined
};

// Converts the information of a pose of the camera to that of a pose of the body it is fixed to.
inline ImageInformation InformationOfBody(const ImageInformation& of_camera, const Pose& T_BC) {
  const Eigen::Matrix3d R_CB = T_BC.R().transpose();
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.topLeftCorner<3, 3>() = J.bottomRightCorner<3, 3>() = R_CB;
  J.topRightCorner<3, 3>() = -R_CB * so3::Hat(T_BC.p());
  return (J.transpose() * of_camera.cast<double>() * J).cast<float>();
}

}  // namespace highwall
