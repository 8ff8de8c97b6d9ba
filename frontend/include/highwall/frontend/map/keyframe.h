#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/map_ids.h>

namespace [[gnu::visibility("default")]] highwall {

class ImuPreintegration;  // highwall/factors/imu_preintegration.h

// The body's motion at a keyframe, and the IMU readings since an earlier one.
struct InertialState {
  Stamp stamp = 0;                                 // [ns] of the IMU's clock
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();  // [m/s]
  ImuBias bias = ImuBias::Zero();                  // [rad/s, m/s^2]
  Eigen::Matrix<double, 6, 1> bias_sigma = Eigen::Matrix<double, 6, 1>::Ones();
  KeyFrameId previous = kNoId;                             // kNoId: no IMU factor to an earlier one
  std::shared_ptr<const ImuPreintegration> from_previous;  // null without `previous`
  // [s] of the time offset that `stamp` has to the stamp of the image; 0: it is known
  double time_offset_sigma = 0.0;
  double weight = 1.0;  // of its IMU factor: the mean over the images in between
};

// What the whole image of a keyframe states about the motion of the camera from an earlier one
// (DirectAligner): it holds a pose where landmarks are few.
struct ImageMotion {
  KeyFrameId reference = kNoId;
  Pose T_reference_C;
  // W with W^T W the information [1/m^2, 1/rad^2] of a translation and a rotation, both in C
  Eigen::Matrix<double, 6, 6> sqrt_information = Eigen::Matrix<double, 6, 6>::Zero();
};

// A keyframe with its pose and the landmarks that it observes: for each kind, such as `points`, one
// for each feature, kNoId where unmatched.
struct KeyFrame : PerKind<LandmarkIds> {
  KeyFrameId id = kNoId;
  SubmapId submap = kFirstSubmap;  // in which it was created
  Frame frame;
  Pose T_WC;
  cv::Mat depth_grid;  // of its features, but 0 on dynamic objects: reference for other frames
  // match ratio when it was tracked: share of the landmarks in view; 0: unknown
  double found = 0.0;
  std::optional<InertialState> motion;      // with an initialized IMU
  std::optional<ImageMotion> image_motion;  // where it held the pose; not in the file of a map
  // Covariance [m^2, rad^2] of T_WC relative to the keyframes around it when it was made, by its
  // image and the IMU: of a translation and a rotation along the axes of C. Not in the file of a
  // map.
  std::optional<Eigen::Matrix<float, 6, 6>> covariance;
};

}  // namespace highwall
