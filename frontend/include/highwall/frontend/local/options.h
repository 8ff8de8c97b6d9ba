#pragma once

#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of a bundle adjustment of keyframes and landmarks.
struct BundleAdjustmentOptions {
  double point_huber = 2.8;  // [sigma] > 0: Huber threshold on the norm of a point's rows
  double line_huber = 2.8;   // [sigma] > 0: the same for a line's rows
  InlierBounds inliers{};
  int first_iterations = 5;   // >= 1: with all observations
  int second_iterations = 8;  // >= 1: without outliers
  double tolerance = 1e-6;    // >= 0: ends earlier if a step lowers the cost by a smaller share
  // > 0: of the first step, as SolveOptions::initial_trust_region_radius. A small one holds poorly
  // measured parameters in place; a large one lets a few steps straighten the bend of a long loop,
  // which costs next to nothing. With lines only, at most 1e4 is used.
  double trust_region = 1e4;

  void Validate() const;
};

// Options of triangulating corners and segments without depth, by the parallax between keyframes.
struct TriangulationOptions {
  int keyframes = 10;  // >= 0: neighbours to match against; 0: no triangulation
  // >= 2: keyframes that must agree, since two alone agree by chance; for a line at least three,
  // since two planes through segments always intersect in one.
  int min_views = 3;
  // >= 0: segments only if a keyframe was tracked by fewer points; with many points they are too
  // few to help (docs/lines.md).
  int scarce_points = 100;
  // > 0, relative to its depth: a less certain one waits for more parallax
  double max_depth_sigma = 0.1;
  int max_hamming = 50;  // [bit] [0, 256]: between corners on each other's epipolar line
  double ratio = 0.8;    // (0, 1]: best against second best on that line

  void Validate() const;
};

// Options of LocalMapper: growth, culling and adjustment of the map around a new keyframe.
struct LocalMapperOptions {
  BundleAdjustmentOptions bundle{};
  int adjusted_keyframes = 12;  // >= 2: maximum number of keyframes moved by it
  int fixed_keyframes = 20;     // >= 1: maximum number of fixed keyframes of it
  int fused_keyframes = 8;      // >= 0: neighbours whose landmarks are searched in a new keyframe
  // A landmark is culled if it is matched in a smaller share of the frames that had it in view, or
  // if, this many keyframes after its creation, fewer keyframes observe it; also if the removal of
  // a keyframe leaves fewer.
  double min_found_ratio = 0.25;  // [0, 1]
  int probation_keyframes = 3;    // >= 1
  int min_observations = 2;       // >= 1
  // A keyframe is culled if this share of its points, or of its lines if it has no points, is
  // observed by so many others, points at levels up to one coarser, lines by twice as many, since
  // they are matched less often. This bounds the map by the area that it covers, however long the
  // camera stays.
  double redundant_share = 0.9;  // (0, 1]; 1 keeps all but exact repeats
  int redundant_observers = 2;   // >= 1
  // With an IMU a keyframe of the last motion_span is kept if its neighbours in time would be left
  // farther apart than this, since a shorter IMU factor is more accurate. An older one is culled,
  // and the IMU factor with it.
  double max_motion_gap = 1.0;  // [s] > 0
  double motion_span = 20.0;    // [s] >= 0
  // > 0, relative to its depth: a less certain corner creates no landmark
  double max_depth_sigma = 0.03;
  double min_line_length = 0.05;  // [m] > 0: shorter segments create no landmark
  // Moves a keyframe's corners to where they match the first appearance of their landmarks.
  bool refine_corners = true;
  TriangulationOptions triangulation{};
  // Wait for an adjustment that is still running when the next keyframe arrives. false: it ends
  // after the current iteration, for a camera that does not wait.
  bool wait = true;

  void Validate() const;
};

}  // namespace highwall
