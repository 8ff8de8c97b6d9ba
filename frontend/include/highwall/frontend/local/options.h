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
  double tolerance = 1e-4;    // >= 0: ends earlier if a step lowers the cost by a smaller share
  // > 0: of the first step, as SolveOptions::initial_trust_region_radius. A small one holds poorly
  // measured parameters in place; a large one lets a few steps straighten the bend of a long loop,
  // which costs next to nothing. With lines only, at most 1e4 is used.
  double trust_region = 1e4;

  void Validate() const;
};

// Options of LocalMapper: growth, culling and adjustment of the map around a new keyframe.
struct LocalMapperOptions {
  int adjusted_keyframes = 12;  // >= 2: maximum number of keyframes moved by an adjustment
  int fixed_keyframes = 20;     // >= 1: maximum number of fixed keyframes of it
  int fused_keyframes = 8;      // >= 0: neighbours whose landmarks are searched in a new keyframe
  // >= 1: a landmark is culled if, some keyframes after its creation, fewer keyframes observe it;
  // also if the removal of a keyframe leaves fewer.
  int min_observations = 2;
  // Moves a keyframe's corners to where they match the first appearance of their landmarks.
  bool refine_corners = true;
  // Wait for an adjustment that is still running when the next keyframe arrives. false, for a
  // camera that does not wait: the keyframe is postponed; if it cannot be (SlamSystem::SetBacklog),
  // the adjustment ends after the current iteration.
  bool wait = true;

  void Validate() const;
};

}  // namespace highwall
