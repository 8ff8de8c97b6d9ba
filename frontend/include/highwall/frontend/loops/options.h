#pragma once

#include <highwall/core/pose_graph.h>
#include <highwall/frontend/map/options.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Standard deviations of the relative poses between keyframes.
struct KeyFrameGraphOptions {
  double drift_translation = 0.05;  // > 0: share of the distance between two keyframes
  double drift_rotation = 0.05;     // > 0: share of the angle between them
  // >= 0: share of the errors of a step that is the same in every step (a bias), so that the
  // variance over n steps is 1 + n drift_bias^2 times that of steps with independent errors.
  double drift_bias = 0.05;
  double loop_translation = 0.02;  // [m] > 0: of a loop closure
  double loop_rotation = 0.01;     // [rad] > 0
  // > 0: a loop with a larger squared distance (LoopChi2), or a larger residual in the solved
  // graph, is rejected as false. 99.9 % of the true ones lie within it if the drift is as above.
  double max_loop_chi2 = 22.458;
  int min_shared = kSharedByEdge;  // >= 1: shared landmarks that make an edge between two keyframes
  int neighbours = 3;  // >= 0: maximum number of such edges from a keyframe to older ones
  // Rotations keep the direction of gravity, the z axis of W, where the map knows it: four degrees
  // of freedom remain.
  bool hold_gravity = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Criteria by which LoopDetector recognizes a place that was seen before.
struct LoopDetectorOptions {
  // >= 1: consecutive keyframes that propose one place before it is verified; at the end of a run,
  // where no more follow, one of the last three suffices, or two that agree between submaps.
  int consistency = 3;
  // >= 6: inlier points plus twice the inlier lines, after the search by projection
  int min_support = 50;
  // [0, 1]: match ratio, the share of the landmarks in view that are matched, relative to the match
  // ratio of the keyframe in its own surroundings: a blurred image matches few in either. Where
  // that is unknown it is taken to be one half.
  double min_found = 0.5;
  // [0, 1]: the same between submaps, where no drift bound can reject a false match, and of loops
  // at the end of a run, where no more keyframes will confirm one. Between submaps it is 1 then.
  double min_match_ratio_across_submaps = 0.75;
  // >= 1: decisive ratio. Between submaps one keyframe suffices if its support is this many times
  // min_support and it matches as much as in its own surroundings; otherwise `consistency`
  // keyframes in a row must agree on the transform (two of the last three at the end of a run).
  double decisive_ratio = 2.0;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the map correction after a loop closure.
struct LoopCorrectionOptions {
  RobustLoops robust = RobustLoops::kGnc;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of LoopCloser.
struct LoopCloserOptions {
  bool enabled = true;
  KeyFrameGraphOptions graph{};  // the drift that is considered possible
  LoopDetectorOptions detector{};
  LoopCorrectionOptions correction{};
  bool adjust = true;  // run global bundle adjustment after a loop closure

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the adjustment of keyframes to user factors (docs/user_factors.md).
struct UserFactorOptions {
  int every = 20;  // >= 1: factors added to the map since the last adjustment
  // >= 0: minimum share of those in earlier adjustments: a long trajectory is adjusted less often
  double share = 0.05;
  double max_angle = 0.1;  // [rad] > 0: sigma of the rotation below which a frame counts as aligned
  // [s] > 0: a measurement between two frames that are farther apart is refused.
  double max_gap = 0.5;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
