#pragma once

#include <highwall/frontend/pose/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of the detection of dynamic objects.
struct DynamicObjectOptions {
  bool enabled = true;
  // (0, 1]: if more of the image seems to move, the pose is considered wrong instead
  double max_share = 0.6;

  void Validate() const;
};

// Fallback constraints on surfaces for poses that points and lines leave degenerate (without an
// IMU, which bridges such frames by itself); they also distinguish dynamic objects from small pose
// errors. Points of the image are constrained to the planar patches seen by the reference keyframe.
struct SurfaceTrackingOptions {
  bool enabled = true;  // false: neither is done
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
  DynamicObjectOptions moving{};
  DegeneracyOptions degeneracy{};
  SurfaceTrackingOptions surfaces{};
  DirectAlignmentOptions direct{};  // where nothing else constrains the pose and no IMU predicts it
  // >= 6: minimum support (PoseSolverOptions) to accept a pose, after matching the local map.
  int min_support = 25;
  // [0, 1]: repeated patterns can produce a false pose that a few matches support. A pose whose
  // support is below this share of the landmarks of the local map in view is ambiguous: the pose by
  // descriptor matching with the reference keyframe is then tried as well, and the better supported
  // one is kept.
  double doubtful_share = 0.06;
  int local_keyframes = 24;  // >= 1: maximum number of keyframes whose landmarks are searched

  void Validate() const;
};

// Options of the non-keyframe refinement: poses of frames are refined afterwards in the grown map
// (docs/tracking.md).
struct FrameRefinementOptions {
  bool enabled = true;
  int waiting = 300;  // >= 1: maximum number of waiting frames; batches of at least thirty
  // At the end, poses from images alone are smoothed over time, by what their images state and by
  // the accelerations that the camera usually has.
  bool smooth = true;

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
  // >= 0: and more than this number of points with depth has no landmark yet, not counting, while
  // wanted_tracked landmarks of any kind are tracked, those that the last keyframe did not help.
  int wanted_new = 50;

  void Validate() const;
};

}  // namespace highwall
