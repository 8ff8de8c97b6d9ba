#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/core/trajectory_error.h>

namespace highwall::internal {

struct PositionAlignment {
  Similarity S_AB{};
  OpenRotation open = OpenRotation::kNone;  // the part of R_AB that is unobservable, arbitrary then
  Eigen::Vector3d line_A = Eigen::Vector3d::Zero();  // unit, of kAboutLine
  Eigen::Vector3d mean_A = Eigen::Vector3d::Zero();
};

// As AlignUmeyama(), but positions on a line or in a point are accepted. Returns empty, and the
// reason in `fault`, for fewer than three positions, and if a scale is requested for positions in
// one point.
std::optional<PositionAlignment> AlignPositions(const Eigen::Matrix3Xd& a,
                                                const Eigen::Matrix3Xd& b, bool with_scale,
                                                std::string* fault);

// The same for positions and attitudes: the attitudes determine the rotation that is not observable
// from the positions. Both trajectories have the same number of poses. Throws InvalidArgument with
// the reason where AlignPositions() returns none.
PositionAlignment AlignPoses(const Trajectory& a, const Trajectory& b, bool with_scale);

}  // namespace highwall::internal
