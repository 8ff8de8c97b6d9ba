#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// A segment, undistorted, and the pose of the camera that saw it.
struct LineView {
  Pose T_WC;
  LineSegment segment;  // [px] at least 1 px long
  double sigma = 1.0;   // [px] of its ends, across it
};

// A line as its first view has it: how far from the segment's ends s and e its image passes, along
// (-d_y, d_x) of the unit direction d from s to e, and how far away it is there.
struct LineInView {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();         // [px] at s, at e
  Eigen::Vector2d inverse_depth = Eigen::Vector2d::Zero();  // [1/m] 1/z at s, at e
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();     // of both, in this order
};

struct TriangulatedLine {
  Segment3 segment_W;  // [m] what the first view saw of it
  LineInView seen;     // by the first view; its covariance is that of the segments' noise alone
  std::vector<double> squared_errors;  // |r|^2 of the two rows of each view; the sum is chi-square
                                       // of 2 n - 4
};

// The most likely line behind segments of three or more images whose poses are known, by their rows
// across the image alone: what is along a segment is not measured (OrthonormalLineReprojection).
// Two views are enough to name a line, none is left then that could deny it. Empty where the line
// would be behind a camera, or where its distance stays open: the planes through the cameras and
// their segments are one, since the cameras moved along the line or within its plane. Where they
// are nearly one the covariance says so. Start: where the rays of the first view's ends meet the
// planes of the others; then Levenberg-Marquardt. (Bartoli, Sturm, "Structure-from-motion using
// lines", CVIU 2005, section 3: the linear start and why it does not suffice. The four numbers are
// those of an inverse-depth point at either end: Civera, Davison, Montiel, "Inverse depth
// parametrization for monocular SLAM", T-RO 2008.)
std::optional<TriangulatedLine> TriangulateLine(const MeasurementModel& model,
                                                std::span<const LineView> views);

}  // namespace highwall
