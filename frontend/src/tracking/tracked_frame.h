#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/pose/pose_report.h>

#include "pose/degeneracy.h"
#include "tracking/loss_clues.h"

namespace highwall {

// A frame with its pose and the landmarks its features were found to be.
struct TrackedFrame {
  Frame frame;
  TrackingState state = TrackingState::kLost;
  bool relocalized = false;        // found again in this frame
  bool by_image = false;           // its image alone tells its pose: no IMU, no adjustment
  Pose T_WC;                       // meaningful where HasPose(state)
  KeyFrameId reference = kNoId;    // the keyframe that shares most landmarks
  SubmapId submap = kFirstSubmap;  // that a keyframe made of it joins
  std::vector<PointId> points;     // per point feature, kNoId where unmatched; inliers only
  std::vector<LineId> lines;       // per line feature
  // The same as they were matched, outliers included.
  std::vector<PointId> tried_points;
  std::vector<LineId> tried_lines;
  // Cells that move (MovingObjects::Find); empty where nothing does. Features there are not among
  // those of `frame`.
  cv::Mat moving;
  int num_points = 0, num_lines = 0;  // matched
  double found = 0.0;                 // share of the local map's landmarks in view that it sees
  int num_planes = 0;                 // points of the image on flat patches of the reference
  // What the matches alone say of the pose (PoseSolution); without any, all of the image
  // (DirectAligner).
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double error = 1.0;
  std::vector<OpenDirection> open;  // directions of the pose that they leave open
  LossClues clues;                  // where there is no pose
};

}  // namespace highwall
