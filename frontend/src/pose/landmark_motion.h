#pragma once

#include <span>

#include <highwall/core/pose.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/pose/options.h>

#include "pose/pose_solver.h"

namespace highwall {

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
