#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/pose/options.h>

#include "pose/known_pose.h"

namespace highwall {

// A known world point and the rows of its observation; rows beyond `dimension` are zero.
struct PosePoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // [m]
  ProjectionRows<3> rows;
  int dimension = 3;     // 2 or 3
  NoiseFactors noise{};  // of the feature
};

// A known world line and the rows of its observation in the end-point form. The ends lie on the
// line where the observed ends see it (TrimToObservation), so that what is measured is the distance
// at the observed ends and not at those of a longer map line.
struct PoseLine {
  Segment3 segment_W;  // [m]
  std::array<ProjectionRows<2>, 2> rows;
  int dimension = 4;     // 2 or 4
  NoiseFactors noise{};  // of the feature
};

struct PoseSolution {
  Pose T_WC;
  // Of the inliers' rows alone, without what is known from elsewhere: J^T J and J^T r at T_WC, in
  // the tangent of PoseManifold. Singular where they leave a direction open.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double error = 1.0;  // of the same rows: |r|^2 per degree of freedom, 1 where the noise is right
  std::vector<bool> point_inliers;
  std::vector<bool> line_inliers;
  int num_points = 0;  // inliers
  int num_lines = 0;   // inliers
  int num_planes = 0;  // inliers
  double depth = 0.0;  // [m] median of the inliers' in C, those on planes not counted
};

// Camera pose from known points and lines: robust Levenberg-Marquardt (ceres::TinySolver) in the
// tangent space at T_WC, with outliers set aside between rounds; where too few remain, once more
// from pixels and lines, with the depth of those points alone whose depth fits. B = C in
// `projection`. known: where not null, joins the least squares. planes: the row's frames are W and
// C; they join the least squares as well, and do not count as support. Empty where less than
// min_support remains or the steps stop being finite.
std::optional<PoseSolution> SolvePose(const Pose& T_WC, const RgbdProjection& projection,
                                      std::span<const PosePoint> points,
                                      std::span<const PoseLine> lines,
                                      const PoseSolverOptions& options = {},
                                      const KnownPose* known = nullptr,
                                      std::span<const PointToPlaneRow> planes = {});

// The piece of line_C [m] that the undistorted pixels s and e see: each end is the point of the
// line nearest to the ray. Empty where that is behind the camera or the ray runs along the line.
std::optional<Segment3> TrimToObservation(const PluckerLine& line_C, const Eigen::Vector2d& s,
                                          const Eigen::Vector2d& e, const RgbdProjection& camera);

}  // namespace highwall
