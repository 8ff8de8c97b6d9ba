#pragma once

#include <span>

#include <highwall/core/pose.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {

// Criteria for dynamic landmarks.
struct LandmarkMotionOptions {
  int min_points = 8;      // >= 1: inconsistent with the pose of all others ...
  double min_share = 0.7;  // (0, 1]: and this share of those that are tested
  double outnumber = 1.0;  // > 0: minimum support of the others relative to that of the tested ones
};

// Returns whether the landmarks on one surface have moved relative to all others: most of them are
// inconsistent with the pose by the others alone, beyond the noise of both. In a pose by all
// together, near and slowly moving landmarks would outweigh the static ones: they would be
// consistent, and the camera wrong. T_WC: rough pose, B = C in `projection`. judged_lines: number
// of lines on the surface; they are not tested, but count in its share of the scene, as two points
// each. False if the others give no pose or are too few: of two bodies in relative motion, the one
// with the larger share of the scene is static.
bool HaveMoved(const Pose& T_WC, const RgbdProjection& projection,
               std::span<const PosePoint> judged, int judged_lines,
               const PerKind<PoseObservations>& others, const LandmarkMotionOptions& options = {});

}  // namespace highwall
