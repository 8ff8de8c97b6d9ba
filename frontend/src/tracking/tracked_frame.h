#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/keyframe.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/pose/pose_report.h>

#include "pose/degeneracy.h"
#include "tracking/tracking_diagnostics.h"

namespace highwall {

// A frame with its pose and its matched landmarks, inliers only: for each kind, such as `points`,
// one for each feature, kNoId where unmatched.
struct TrackedFrame : PerKind<LandmarkIds> {
  Frame frame;
  TrackingState state = TrackingState::kLost;
  bool relocalized = false;        // pose found by relocalization
  bool by_image = false;           // pose estimated from its image, and not adjusted since
  Pose T_WC;                       // meaningful where HasPose(state)
  KeyFrameId reference = kNoId;    // the keyframe that shares most landmarks
  SubmapId submap = kFirstSubmap;  // that a keyframe made of it joins
  PerKind<LandmarkIds> tried;      // the same landmarks before outlier rejection
  // Dynamic mask (DynamicObjects::Find); empty without dynamic objects. Masked features have been
  // removed from `frame`.
  cv::Mat moving;
  int num_points = 0, num_lines = 0;  // matched
  double found = 0.0;                 // match ratio: share of the local map's landmarks in view
  std::optional<ImageMotion> image_motion;  // if the whole image held the pose
  int num_planes = 0;  // points of the image on planar patches of the reference
  // Information of the pose from the matches alone (PoseSolution); without matches, from the whole
  // image (DirectAligner).
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double error = 1.0;
  std::vector<UnobservableDirection> open;  // unobservable directions of the pose
  TrackingDiagnostics diagnostics;          // if there is no pose
};

}  // namespace highwall
