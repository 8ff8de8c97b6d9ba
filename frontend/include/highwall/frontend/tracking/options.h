#pragma once

#include <cstdint>

#include <highwall/frontend/map/options.h>
#include <highwall/frontend/pose/options.h>

namespace [[gnu::visibility("default")]] highwall {

// How a lost camera finds its place in the map.
struct RelocalizerOptions {
  int candidates = 5;           // >= 1: keyframes verified, most alike first
  int max_hamming = 60;         // [bit] of a match
  double ratio = 0.8;           // (0, 1]: best against second best
  int min_matches = 15;         // >= 3: with a keyframe, to verify it
  int min_inliers = 20;         // >= 6: points plus twice the lines, after RANSAC and refinement
  int min_line_inliers = 8;     // >= 4: lines after refinement, where there are too few points
  int ransac_iterations = 200;  // >= 1
  std::uint32_t seed = 1;

  void Validate() const;
};

// What counts as moving.
struct MovingObjectOptions {
  bool enabled = true;
  double settled = 1.5;      // [s] > 0: what was seen in place this long before or after stands
  double max_share = 0.6;    // (0, 1]: where more of the image seems to move, the pose is to blame
  double interval = 0.5;     // [s] > 0: between the frames that are remembered
  double history = 4.0;      // [s] > interval: how long they are
  int min_surface = 40;      // >= 1 [cells] of a surface that is judged by its landmarks
  double max_surface = 0.5;  // (0, 1]: share of the image that it may have
  LandmarkMotionOptions landmarks{};  // when they tell that a surface moves

  void Validate() const;
};

// How surfaces hold a pose that points and lines alone do not (without an IMU, which bridges such
// frames by itself), and tell whether something moves or the pose is a little off: points of the
// image lie on the flat patches that the reference keyframe saw.
struct SurfaceTrackingOptions {
  bool enabled = true;  // off: neither is done
  SurfaceMatcherOptions matcher{};
  int min_support = 6;     // >= 3, of points and lines (PoseSolverOptions)
  int min_rows = 30;       // >= 1, on patches
  double max_sigma = 0.2;  // [m] > 0: a pose with a more open direction is none

  void Validate() const;
};

// What becomes of the times of the rows (FrameTiming).
enum class FrameTimingMode {
  kIgnored,    // every image is of one time, and depth of that of its image
  kKnown,      // as the sensor's timing and the stamps of depth images say
  kEstimated,  // found out while tracking, beginning there
};

// "ignored", "known" or "estimated".
const char* ToString(FrameTimingMode mode);

// How frames are followed.
struct TrackerOptions {
  FrameTimingMode timing = FrameTimingMode::kEstimated;
  // Off: noise is as MeasurementOptions and DepthNoise say, and so it is with Weighting::kPaper.
  bool learn_noise = true;
  PoseSolverOptions pose{};
  RelocalizerOptions relocalizer{};
  MovingObjectOptions moving{};
  DegeneracyOptions degeneracy{};
  SurfaceTrackingOptions surfaces{};
  DirectAlignmentOptions direct{};  // of what nothing else holds, while no IMU predicts
  // Support (PoseSolverOptions) for a pose to be believed, >= 6: after the first match against the
  // last frame or keyframe, and after the local map.
  int min_motion_support = 15;
  int min_support = 25;
  // The same for both where the pose is predicted by an IMU, which tells wrong matches, >= 6.
  int min_predicted_support = 12;
  // A pose may be a coincidence of repeated patterns, on which a few agree and most deny it, where
  // its support is less than the first share of that of all first matches, less than the second of
  // the landmarks of the local map in view, or less than the third of the last frame's support, all
  // in [0, 1]: what the descriptors of the reference keyframe say is tried as well, and the better
  // supported pose is kept. Where most first matches deny it, it must leave no direction open.
  double doubtful_agreement = 0.33;
  double doubtful_share = 0.06;
  double doubtful_drop = 0.3;
  int local_keyframes = 24;  // >= 1: most keyframes whose landmarks are searched
  // A place that is recognized, whatever the motion says, may be another one that looks alike: of
  // the landmarks in view at least this share of what frames usually find must be there, and no
  // more than this share of the depth may be contradicted either way (DepthContradiction), both in
  // [0, 1].
  double recognized_found = 0.5;
  double recognized_contradiction = 0.1;

  void Validate() const;
};

// When the poses of frames are found once more, in the map that has grown meanwhile
// (docs/tracking.md).
struct FrameRefinementOptions {
  bool enabled = true;
  int keyframes = 10;      // >= 0: that were made since
  int waiting = 300;       // >= 1: frames that wait for that, at most, or thirty
  int rounds = 3;          // >= 1: where rows have times, the motion between frames is found anew
  bool background = true;  // on a thread of its own; else at once

  void Validate() const;
};

// When a frame becomes a keyframe.
struct KeyFramePolicyOptions {
  // >= 6: with depth, points plus four times lines, to start a map: four times what a pose needs,
  // for not all of them are found again.
  int min_features = 100;
  double min_share = 0.75;   // (0, 1]: of the reference keyframe's landmarks found again
  // [s] > 0: since the last keyframe, ten frames of thirty a second; without an IMU a camera that
  // stands still makes none.
  double max_gap = 0.32;
  int wanted_tracked = 100;  // >= 0: a keyframe is due when fewer points with depth are tracked
  int wanted_new = 70;       // >= 0: than this and more than that wait to become landmarks

  void Validate() const;
};

}  // namespace highwall
