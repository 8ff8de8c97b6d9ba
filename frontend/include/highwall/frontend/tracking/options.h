#pragma once

#include <cstdint>

#include <highwall/frontend/map/options.h>
#include <highwall/frontend/pose/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of Relocalizer, which finds the pose of a lost camera in the map.
struct RelocalizerOptions {
  int candidates = 5;           // >= 1: keyframes verified, most similar first
  int max_hamming = 60;         // [bit] of a match
  double ratio = 0.8;           // (0, 1]: best against second best
  int min_matches = 15;         // >= 3: with a keyframe, to verify it
  int min_inliers = 20;         // >= 6: points plus twice the lines, after RANSAC and refinement
  int min_line_inliers = 8;     // >= 4: lines after refinement, where there are too few points
  int ransac_iterations = 200;  // >= 1
  std::uint32_t seed = 1;

  void Validate() const;
};

// Options of the detection of dynamic objects.
struct DynamicObjectOptions {
  bool enabled = true;
  double settled = 1.5;  // [s] > 0: a surface seen in place this long before or after is static
  // (0, 1]: if more of the image seems to move, the pose is considered wrong instead
  double max_share = 0.6;
  double interval = 0.5;  // [s] > 0: between the frames that are stored
  double history = 4.0;   // [s] > interval: how long they are stored
  int min_surface = 40;   // >= 1 [cells] of a surface that is judged by its landmarks
  // (0, 1]: maximum size of such a surface, as a share of the cells with depth
  double max_surface = 0.5;
  LandmarkMotionOptions landmarks{};  // when they indicate that a surface moves

  void Validate() const;
};

// Fallback constraints on surfaces for poses that points and lines leave degenerate (without an
// IMU, which bridges such frames by itself); they also distinguish dynamic objects from small pose
// errors. Points of the image are constrained to the planar patches seen by the reference keyframe.
struct SurfaceTrackingOptions {
  bool enabled = true;  // false: neither is done
  SurfaceMatcherOptions matcher{};
  int min_support = 6;     // >= 3, from points and lines (PoseSolverOptions)
  int min_rows = 30;       // >= 1, on patches
  double max_sigma = 0.2;  // [m] > 0: a pose whose worst direction exceeds this is rejected

  void Validate() const;
};

// Mode of the rolling-shutter compensation (FrameTiming).
enum class FrameTimingMode {
  kIgnored,    // global shutter; depth is taken at the stamp of its image
  kKnown,      // by the sensor's timing and the stamps of depth images
  kEstimated,  // estimated online while tracking, starting from kKnown
};

// Returns "ignored", "known" or "estimated".
const char* ToString(FrameTimingMode mode);

// Options of Tracker.
struct TrackerOptions {
  FrameTimingMode timing = FrameTimingMode::kEstimated;
  // false: noise is as in MeasurementOptions and DepthNoise, as always with Weighting::kPaper.
  bool learn_noise = true;
  PoseSolverOptions pose{};
  RelocalizerOptions relocalizer{};
  DynamicObjectOptions moving{};
  DegeneracyOptions degeneracy{};
  SurfaceTrackingOptions surfaces{};
  DirectAlignmentOptions direct{};  // where nothing else constrains the pose and no IMU predicts it
  // Minimum support (PoseSolverOptions) to accept a pose, >= 6: after the first match against the
  // last frame or keyframe, and after matching the local map.
  int min_motion_support = 15;
  int min_support = 25;
  // The same for both if the pose is predicted by an IMU, which exposes wrong matches, >= 6.
  int min_predicted_support = 12;
  // Repeated patterns can produce a false pose that a few matches support and most are inconsistent
  // with. A pose is ambiguous if its support is below the first share of that of all first matches,
  // below the second of the landmarks of the local map in view, or below the third of the last
  // frame's support, all in [0, 1]: the pose by descriptor matching with the reference keyframe is
  // then tried as well, and the better supported one is kept. If most first matches are
  // inconsistent with a pose, it must have no unobservable direction.
  double doubtful_agreement = 0.33;
  double doubtful_share = 0.06;
  double doubtful_drop = 0.3;
  int local_keyframes = 24;  // >= 1: maximum number of keyframes whose landmarks are searched
  // A recognized place (found without the motion model) may be a similar one: its share of matched
  // landmarks in view must be at least this fraction of the mean match ratio of frames, and no more
  // than this share of the depth may be inconsistent in either direction (DepthContradiction), both
  // in [0, 1].
  double recognized_found = 0.5;
  double recognized_contradiction = 0.1;

  void Validate() const;
};

// Options of the non-keyframe refinement: poses of frames are refined afterwards in the grown map
// (docs/tracking.md).
struct FrameRefinementOptions {
  bool enabled = true;
  int keyframes = 10;  // >= 0: keyframes created since the frame
  int waiting = 300;   // >= 1: maximum number of waiting frames; batches of at least thirty
  // >= 1: with rolling shutter, the motion between frames is re-estimated per round
  int rounds = 3;

  void Validate() const;
};

// Criteria by which a frame becomes a keyframe.
struct KeyFramePolicyOptions {
  // >= 6: points with depth plus four times lines, to start a map: four times what a pose needs,
  // since not all of them are matched again.
  int min_features = 100;
  double min_share = 0.75;  // (0, 1]: of the reference keyframe's landmarks matched again
  // [s] > 0: since the last keyframe, ten frames at 30 Hz; without an IMU a stationary camera
  // creates none.
  double max_gap = 0.32;
  int wanted_tracked = 100;  // >= 0: a keyframe is due if fewer points with depth are tracked
  int wanted_new = 70;  // >= 0: and more than this number of points with depth has no landmark yet

  void Validate() const;
};

}  // namespace highwall
