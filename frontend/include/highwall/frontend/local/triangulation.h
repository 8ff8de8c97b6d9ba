#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

// A corner and the pose of its camera.
struct PointView {
  Pose T_WC;
  PointFeature feature;
};

// Result of TriangulatePoint.
struct TriangulatedPoint {
  Eigen::Vector3d p_W;         // [m]
  Eigen::Matrix3d covariance;  // [m^2] of p_W, from the noise of the features alone
  double squared_error = 0.0;  // |r|^2 of all rows, chi-square of 2 (n - 1) - 1 and one a depth
};

// Returns the maximum-likelihood point of corners of two or more images with known poses, with
// their noise (MeasurementModel) and their depth if available. Empty if the rays do not meet in
// front of the cameras, or are too parallel for a distance.
// Initialized at the point nearest to all rays; then Levenberg-Marquardt (Hartley, Zisserman,
// "Multiple View Geometry", 2nd ed., section 12.5, with the covariance of section 5.2).
std::optional<TriangulatedPoint> TriangulatePoint(const MeasurementModel& model,
                                                  std::span<const PointView> views);

// A segment, undistorted, and the pose of its camera.
struct LineView {
  Pose T_WC;
  LineSegment segment;  // [px] at least 1 px long
  double sigma = 1.0;   // [px] of its ends, across it
};

// A line in its first view: the offsets of its image from the segment's ends s and e along (-d_y,
// d_x) of the unit direction d from s to e, and its inverse depths there.
struct LineInView {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();         // [px] at s, at e
  Eigen::Vector2d inverse_depth = Eigen::Vector2d::Zero();  // [1/m] 1/z at s, at e
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();     // of both, in this order
};

// Result of TriangulateLine.
struct TriangulatedLine {
  Segment3 segment_W;  // [m] as observed by the first view
  LineInView seen;     // in the first view; the covariance includes the segments' noise alone
  std::vector<double> squared_errors;  // |r|^2 of the two rows of each view; the sum is chi-square
                                       // of 2 n - 4
};

// Returns the maximum-likelihood line of segments of three or more images with known poses, by
// their rows across the image alone: the position along a segment is not measured
// (OrthonormalLineReprojection). Two views suffice for a solution, but leave no redundancy to
// verify it. Empty if the line would be behind a camera, or if its distance is unobservable: the
// planes through the cameras and their segments coincide, because the cameras moved along the line
// or within its plane. If they nearly coincide the covariance is large. Initialized where the rays
// of the first view's ends meet the planes of the others; then Levenberg-Marquardt. (Bartoli,
// Sturm, "Structure-from-motion using lines", CVIU 2005, section 3: the linear start and why it
// does not suffice. The four numbers are those of an inverse-depth point at either end: Civera,
// Davison, Montiel, "Inverse depth parametrization for monocular SLAM", T-RO 2008.)
std::optional<TriangulatedLine> TriangulateLine(const MeasurementModel& model,
                                                std::span<const LineView> views);

}  // namespace highwall
