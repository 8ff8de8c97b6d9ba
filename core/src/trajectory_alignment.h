#pragma once

#include <Eigen/Core>

#include <highwall/core/trajectory_error.h>

namespace highwall::internal {

struct PositionAlignment {
  Similarity S_AB{};
  OpenRotation open = OpenRotation::kNone;  // what of R_AB the positions leave open; it is any then
  Eigen::Vector3d line_A = Eigen::Vector3d::Zero();  // unit, of kAboutLine
  Eigen::Vector3d mean_A = Eigen::Vector3d::Zero();
};

// As AlignUmeyama(), but positions on a line or in a point are no error. Throws InvalidArgument for
// fewer than three of them, and where a scale is wanted of positions in one point.
PositionAlignment AlignPositions(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                                 bool with_scale);

// The same of positions and attitudes: these decide the rotation that the positions leave open.
// Both trajectories have the same number of poses.
PositionAlignment AlignPoses(const Trajectory& a, const Trajectory& b, bool with_scale);

}  // namespace highwall::internal
