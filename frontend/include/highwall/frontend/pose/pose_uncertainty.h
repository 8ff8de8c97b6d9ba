#pragma once

#include <Eigen/Core>

#include <highwall/frontend/map/map_ids.h>

namespace [[gnu::visibility("default")]] highwall {

// How uncertain the pose of a frame is: covariances of a translation [m], then a rotation [rad],
// both along the axes of C (docs/pose_uncertainty.md).
struct PoseUncertainty {
  // The keyframe that shares most landmarks with the frame, another one than the frame's own.
  KeyFrameId reference = kNoId;
  // Of the pose relative to this keyframe. Zero for the first frame of a map.
  Eigen::Matrix<double, 6, 6> in_keyframe = Eigen::Matrix<double, 6, 6>::Zero();
  // Of T_WC: the uncertainty of the keyframe in its map is included. A given map (LoadMap) is
  // regarded as exact, and so is the first keyframe of a submap, where its world begins.
  Eigen::Matrix<double, 6, 6> in_map = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace highwall
