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

// Options of the surface matching between two images.
struct SurfaceMatcherOptions {
  int stride = 2;              // [cells] >= 1, between the centres of patches
  int radius = 4;              // [cells] >= 1: a patch has 2 radius + 1 cells to a side
  double min_share = 0.7;      // (0, 1]: cells of a patch that must belong to its surface
  double max_incidence = 1.3;  // [rad] (0, pi/2): between the ray and the normal
  // [rad] > 0: standard deviation of a normal. Less certain normals would constrain a pose in
  // directions that the surface does not observe.
  double max_tilt = 0.05;
  double gate_sigmas = 4.0;  // > 0: a point farther off its plane is rejected; plus
  double gate = 0.03;        // [m] >= 0, for the error of the pose

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the direct alignment of whole images (DirectAligner).
struct DirectAlignmentOptions {
  bool enabled = true;
  int min_rows = 30;             // >= 1, on patches
  double min_correlation = 0.8;  // [0, 1): of the grey levels of both
  double max_sigma = 0.05;       // [m] > 0: a pose whose worst direction exceeds this is rejected

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Criteria for dynamic landmarks.
struct LandmarkMotionOptions {
  int min_points = 8;      // >= 1: inconsistent with the pose of all others ...
  double min_share = 0.7;  // (0, 1]: and this share of those that are tested
  // > 0: of an inconsistent point, in units of the noise of the others: 99.999 % with 3 rows, since
  // errors of landmarks on one surface are correlated.
  double chi2 = 25.9;
  int min_support = 20;    // >= 6: of the others (PoseSolverOptions) ...
  double outnumber = 1.0;  // > 0: and this many times that of the tested ones

  void Validate() const;
};

}  // namespace highwall
