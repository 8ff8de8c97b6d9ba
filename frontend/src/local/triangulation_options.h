#pragma once

namespace highwall {

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
};

}  // namespace highwall
