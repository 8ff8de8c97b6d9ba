#pragma once

#include <highwall/core/pose_graph.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/options.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

// How far the transforms between keyframes may be off: standard deviations.
struct KeyFrameGraphOptions {
  double drift_translation = 0.05;  // > 0: share of the distance between two keyframes
  double drift_rotation = 0.05;     // > 0: share of the angle between them
  double step_translation = 0.005;  // [m] > 0: of every step between them besides
  double step_rotation = 0.003;     // [rad] > 0
  // >= 0; share of all that which is the same in every step, so that over n steps the variance is
  // 1 + n drift_bias^2 times that of steps that are off by chance.
  double drift_bias = 0.05;
  double loop_translation = 0.02;  // [m] > 0: of a loop
  double loop_rotation = 0.01;     // [rad] > 0
  // > 0; a loop beyond this is false: the squared distance of LoopChi2, and what a loop is left
  // with in the solved graph. 99.9 % of true ones are within where the drift is as above.
  double max_loop_chi2 = 22.458;
  int min_shared = kSharedByEdge;  // >= 1: landmarks that make an edge between keyframes
  int neighbours = 3;              // >= 0: most such edges of a keyframe to older ones
  // Where the map knows gravity, rotations keep its direction, W's z axis: four degrees of freedom
  // are left.
  bool hold_gravity = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// When a place counts as seen before.
struct LoopDetectorOptions {
  int candidates = 3;    // >= 1: keyframes looked at, most alike first
  int consistency = 3;   // >= 1: keyframes in a row that name one place before it is verified
  int min_support = 50;  // >= 6: inlier points plus twice the lines, after that search
  // [0, 1]: their share of the landmarks in view, against what the keyframe found in its own
  // surroundings: a blurred image finds few of either. Half are taken to be found at home where
  // that is not known.
  double min_found = 0.5;
  // [0, 1]: the same between submaps, where no drift tells a false one.
  double min_found_apart = 0.75;
  // >= 1: there one keyframe tells enough that has so many times the support, and finds as much as
  // at home; of less, `consistency` keyframes in a row must tell the same transform.
  double overwhelming = 2.0;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How the map is corrected by a loop.
struct LoopCorrectionOptions {
  RobustLoops robust = RobustLoops::kGnc;
  int fused_keyframes = 12;  // >= 0: neighbours on either side of the loop that take part
  int threads = 2;           // >= 1: of the solver; 1 gives bit-equal results on every run

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Whether and how loops are closed.
struct LoopCloserOptions {
  bool enabled = true;
  KeyFrameGraphOptions graph{};  // the drift that is thought possible
  LoopDetectorOptions detector{};
  LoopCorrectionOptions correction{};
  bool adjust = true;  // the whole map after a loop: global bundle adjustment
  // Few steps: the pose graph has brought the map near, and local adjustments go on.
  BundleAdjustmentOptions bundle{
      .first_iterations = 4, .second_iterations = 4, .tolerance = 1e-4, .trust_region = 1e8};
  // On a thread of its own, on a copy of the map; what comes out is applied between frames. false:
  // before InsertKeyFrame returns; the same input then gives the same map.
  bool background = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// When the keyframes are adjusted to factors of the user's (docs/own_factors.md).
struct OwnFactorOptions {
  int every = 20;          // >= 1: factors that have joined the map since the last time
  double share = 0.05;     // >= 0: of all of them, at least: a long way is adjusted less often
  double max_angle = 0.1;  // [rad] > 0: sigma of the rotation of a frame that counts as found
  // [s] > 0: a measurement between two frames that are farther apart counts for nothing.
  double max_gap = 0.5;
  int threads = 2;         // >= 1: of the solver; 1 gives bit-equal results on every run
  bool background = true;  // as LoopCloserOptions::background

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// When it is looked for by how much depth is off over the image (docs/calibration.md).
struct DepthPatternOptions {
  bool enabled = true;
  int first = 12;          // >= 3: keyframes that a world has then
  int most = 60;           // >= 3: of its newest keyframes take part
  bool background = true;  // as LoopCloserOptions::background

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
