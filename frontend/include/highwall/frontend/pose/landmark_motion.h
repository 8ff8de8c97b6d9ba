#pragma once

#include <span>

#include <highwall/core/pose.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {

struct LandmarkMotionOptions {
  int min_points = 8;      // >= 1: that contradict the pose which all others give ...
  double min_share = 0.7;  // (0, 1]: and this share of those that are judged
  // > 0: of a point that contradicts, by the noise that the others show: 99.999 % with 3 rows, for
  // errors of landmarks on one surface go together.
  double chi2 = 25.9;
  int min_support = 20;    // >= 6: that the others must have (PoseSolverOptions) ...
  double outnumber = 1.0;  // > 0: and this many times that of what is judged

  void Validate() const;
};

// Whether the landmarks on one surface have moved against all others: most of them do not fit the
// pose that the others alone give, by more than the noise of both. In the pose of all together what
// moves slowly and is near outweighs what stands: it would fit, and the camera be wrong.
// T_WC: rough pose, B = C in `projection`. judged_lines: how many lines are on the surface; they
// are not asked, but count in what it is of the scene, a line for two points. False where the
// others give no pose or are too few: of two bodies that move against each other, the one that is
// more of the scene stands.
bool HaveMoved(const Pose& T_WC, const RgbdProjection& projection,
               std::span<const PosePoint> judged, int judged_lines,
               std::span<const PosePoint> other_points, std::span<const PoseLine> other_lines,
               const PoseSolverOptions& pose = {}, const LandmarkMotionOptions& options = {});

}  // namespace highwall
