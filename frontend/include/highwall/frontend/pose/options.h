#pragma once

#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// How the pose of one image is solved for.
struct PoseSolverOptions {
  double point_huber = 2.4;  // [sigma] > 0: Huber threshold on the norm of a point's rows
  double line_huber = 2.4;   // [sigma] > 0: the same for a line's rows
  double plane_huber = 1.5;  // [sigma] > 0: of a point on a plane
  InlierBounds inliers{};
  int rounds = 3;          // >= 1: solve, classify inliers, solve again
  int max_iterations = 6;  // >= 1, per round
  // Inlier points plus twice the inlier lines, >= 3: with less there is no solution. A line counts
  // for two points, since both of its ends are measured.
  int min_support = 6;

  void Validate() const;
};

// When an image leaves its pose open.
struct DegeneracyOptions {
  // [m] > 0: a direction is open where the standard deviation along it exceeds this.
  double max_sigma = 0.02;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How surfaces of two images are matched.
struct SurfaceMatcherOptions {
  int stride = 2;              // [cells] >= 1, between the middles of patches
  int radius = 4;              // [cells] >= 1: a patch has 2 radius + 1 cells to a side
  double min_share = 0.7;      // (0, 1]: cells of a patch that must be of its surface
  double max_incidence = 1.3;  // [rad] (0, pi/2): between the ray and the normal
  // [rad] > 0: standard deviation of a normal. Normals that are less certain hold a pose in
  // directions of which the surface says nothing.
  double max_tilt = 0.05;
  double gate_sigmas = 4.0;  // > 0: a point farther off the plane is of something else, plus
  double gate = 0.03;        // [m] >= 0, the error of the pose

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Whole images against each other (DirectAligner).
struct DirectAlignmentOptions {
  bool enabled = true;
  int min_rows = 30;             // >= 1, on patches
  double min_correlation = 0.8;  // [0, 1): of the grey levels of both
  double max_sigma = 0.05;       // [m] > 0: a pose with a more open direction is none

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// When landmarks count as moving.
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

}  // namespace highwall
