#pragma once

#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of the pose solver of one image.
struct PoseSolverOptions {
  double point_huber = 2.4;  // [sigma] > 0: Huber threshold on the norm of a point's rows
  double line_huber = 2.4;   // [sigma] > 0: the same for a line's rows
  double plane_huber = 1.5;  // [sigma] > 0: of a point on a plane
  InlierBounds inliers{};
  int rounds = 3;          // >= 1: solve, classify inliers, solve again
  int max_iterations = 6;  // >= 1, per round
  // >= 3, inlier points plus twice the inlier lines: with less there is no solution. A line counts
  // as two points, since both of its ends are measured.
  int min_support = 6;

  void Validate() const;
};

// Criterion for a degenerate pose.
struct DegeneracyOptions {
  // [m] > 0: a direction is unobservable if the standard deviation along it exceeds this.
  double max_sigma = 0.02;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the direct alignment of whole images, for a pose that nothing else determines.
struct DirectAlignmentOptions {
  bool enabled = true;
};

}  // namespace highwall
