#pragma once

#include <Eigen/Core>

namespace highwall {

// A segment in space, in the camera frame.
struct SegmentDepth {
  Eigen::Vector3d p_C, q_C;   // [m] on the fitted line, behind the segment's ends s and e
  double sigma_p = 0.0;       // [m] standard deviation of p_C.z(), as the fit has it
  double sigma_q = 0.0;       // [m] of q_C.z()
  double inlier_share = 0.0;  // of the measurements used
  double rms = 0.0;           // [m] depth residuals of the inliers
  bool depth_edge = false;    // the two sides differ: only the nearer one was used
};

}  // namespace highwall
