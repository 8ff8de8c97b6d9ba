#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/pose/options.h>
#include <highwall/frontend/pose/pose_constraint.h>
#include <highwall/frontend/pose/pose_observations.h>

namespace [[gnu::visibility("default")]] highwall {

// Of each observation of one kind, whether it is an inlier.
template <class Landmark>
using PoseInliers = std::vector<bool>;

// Result of SolvePose.
struct PoseSolution {
  Pose T_WC;
  // From the inliers' rows alone, without the prior: J^T J and J^T r at T_WC, in the tangent of
  // PoseManifold. Singular if a direction is unobservable.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double error = 1.0;  // of the same rows: |r|^2 per degree of freedom, 1 for the correct noise
  PerKind<PoseInliers> inliers;
  int num_points = 0;  // inliers
  int num_lines = 0;   // inliers
  int num_planes = 0;  // inliers
  double depth = 0.0;  // [m] median over the inliers in C, except planes
};

// Estimates the camera pose from known landmarks: robust Levenberg-Marquardt (ceres::TinySolver) in
// the tangent space at T_WC, with outlier removal between rounds; if too few inliers remain, it is
// repeated with pixels and lines, adding the depth of points only where it is consistent. B = C in
// `projection`. seen: the observations of all kinds, such as {points, lines}. known: a prior, may
// be null. planes: rows with the frames W and C; they are included as well, and do not count as
// support. Empty if less than min_support remains or the steps are not finite.
std::optional<PoseSolution> SolvePose(const Pose& T_WC, const RgbdProjection& projection,
                                      const PerKind<PoseObservations>& seen,
                                      const PoseSolverOptions& options = {},
                                      const PoseConstraint* known = nullptr,
                                      std::span<const PointToPlaneRow> planes = {});

// Returns the part of line_C [m] between the undistorted pixels s and e: each end is the point of
// the line nearest to the ray. Empty if that is behind the camera or the ray is parallel to the
// line.
std::optional<Segment3> TrimToObservation(const PluckerLine& line_C, const Eigen::Vector2d& s,
                                          const Eigen::Vector2d& e, const RgbdProjection& camera);

}  // namespace highwall
