#pragma once

#include <optional>
#include <unordered_map>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/pose/pose_uncertainty.h>

namespace highwall {

// Estimates how uncertain the poses of frames are (docs/pose_uncertainty.md). All covariances are
// of a translation and a rotation along the axes of C, so that they hold however the map moves.
//
// A frame knows its pose from its image or, where that holds less, from the last frames: the
// acceleration of a camera is limited. A keyframe is as uncertain as the most certain of the
// keyframes that it shares most landmarks with, and its own pose relative to that.
class UncertaintyEstimator {
 public:
  using Covariance = Eigen::Matrix<double, 6, 6>;

  explicit UncertaintyEstimator(const VisualNoise& noise) : noise_(noise) {}

  // What the image of a frame states about its pose.
  struct Image {
    Covariance information_C = Covariance::Zero();  // as ImageInformation; zero: nothing
    double error = 1.0;                             // PoseSolution::error
    double observers = 1.0;  // keyframes that observe a landmark of it, on average
  };
  // A frame whose pose its image determines.
  PoseUncertainty OfImage(Stamp stamp, const AnchoredPose& pose, const Image& image);
  // A frame whose pose the IMU determines as well. covariance_C: of the pose in the map around it.
  PoseUncertainty OfSmoother(Stamp stamp, const AnchoredPose& pose, const Covariance& covariance_C);
  // Returns that of a pose which is predicted at constant velocity. now: of the pose dt [s] before.
  static PoseUncertainty Predicted(PoseUncertainty now, double dt);
  // The frame that begins a map.
  PoseUncertainty OfOrigin(Stamp stamp);

  // Adds the keyframe that was made of the last frame, and sets its KeyFrame::covariance.
  void AddKeyFrame(KeyFrameId id, Map* map);

 private:
  // Returns the covariance of a pose in the map. in_keyframe: of it relative to this keyframe.
  Covariance InMap(KeyFrameId keyframe, const Pose& T_keyframe_C,
                   const Covariance& in_keyframe) const;

  VisualNoise noise_;
  // The last frame of which an image or the IMU states something.
  std::optional<Stamp> measured_;
  Covariance covariance_ = Covariance::Zero();
  // Of the last frame relative to the map around it, if it becomes a keyframe.
  Covariance of_keyframe_ = Covariance::Zero();
  // Of the keyframes of this run in their map, along their own axes.
  std::unordered_map<KeyFrameId, ImageInformation> keyframes_;
};

}  // namespace highwall
