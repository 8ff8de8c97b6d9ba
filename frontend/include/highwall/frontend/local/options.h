#pragma once

#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Of an adjustment of keyframes and landmarks.
struct BundleAdjustmentOptions {
  double point_huber = 2.8;  // [sigma] > 0: Huber threshold on the norm of a point's rows
  double line_huber = 2.8;   // [sigma] > 0: the same for a line's rows
  InlierBounds inliers{};
  int first_iterations = 5;   // >= 1: with all observations
  int second_iterations = 8;  // >= 1: without outliers
  double tolerance = 1e-6;    // >= 0: ends before, where a step lowers the cost by a smaller share
  // > 0: of the first step, as SolveOptions::initial_trust_region_radius. Small, it holds what is
  // measured badly where it was; large, it lets a few steps straighten the bend of a long loop,
  // which costs next to nothing. Of lines alone none larger than 1e4 is taken.
  double trust_region = 1e4;
  int threads = 2;  // >= 1; with more than one the last bits vary from run to run

  void Validate() const;
};

// Landmarks from corners and segments without depth, by the parallax between keyframes.
struct TriangulationOptions {
  int keyframes = 10;  // >= 0: neighbours that they are looked for in; 0: none is made
  // >= 2: keyframes that must agree, for two alone agree by chance; of a line three at the least,
  // for two planes through segments always meet in one.
  int min_views = 3;
  // >= 0: of segments only where a keyframe was tracked by fewer points; beside many they are too
  // few to help (docs/lines.md).
  int scarce_points = 100;
  double max_depth_sigma = 0.1;  // > 0, of its depth: one known worse waits for more parallax
  int max_hamming = 50;          // [bit] [0, 256]: of corners on each other's epipolar line
  double ratio = 0.8;            // (0, 1]: best against second best there

  void Validate() const;
};

// How the map grows, and is cleaned and adjusted, around a new keyframe.
struct LocalMapperOptions {
  BundleAdjustmentOptions bundle{.threads = 1};  // tracking takes the others
  int adjusted_keyframes = 12;                   // >= 2: most keyframes moved by a local adjustment
  int fixed_keyframes = 20;                      // >= 1: most keyframes that hold it in place
  int fused_keyframes = 8;  // >= 0: neighbours whose landmarks are looked for in a new keyframe
  // A landmark is dropped when found in fewer of the frames that had it in view, or when, this
  // many keyframes after its creation, fewer keyframes observe it; also where the removal of a
  // keyframe leaves fewer.
  double min_found_ratio = 0.25;  // [0, 1]
  int probation_keyframes = 3;    // >= 1
  int min_observations = 2;       // >= 1
  // A keyframe is dropped when this share of its points, or of its lines where it has no points, is
  // observed by so many others, points at levels up to one coarser, lines by twice as many,
  // for they are found less often. This bounds the map by the area that it covers, however long the
  // camera stays.
  double redundant_share = 0.9;  // (0, 1]; 1 keeps all but exact repeats
  int redundant_observers = 2;   // >= 1
  // With an IMU a keyframe of the last motion_span is kept where its neighbours in time would be
  // left farther apart than this, for the IMU ties them the better the nearer they are. An older
  // one goes, and the tie with it.
  double max_motion_gap = 1.0;    // [s] > 0
  double motion_span = 20.0;      // [s] >= 0
  double max_depth_sigma = 0.03;  // > 0, of its depth: a corner known worse makes no landmark
  double min_line_length = 0.05;  // [m] > 0: shorter segments make no landmark
  // A keyframe's corners of landmarks are moved to where these look as they did first. Without an
  // IMU.
  bool refine_corners = true;
  TriangulationOptions triangulation{};
  // The local adjustment runs on a thread of its own and is applied between frames. false: before
  // InsertKeyFrame returns; the same input then gives the same map.
  bool background = true;
  // For an adjustment that still runs when the next keyframe comes. false: it ends after the
  // running iteration, for a camera that does not wait.
  bool wait = true;

  void Validate() const;
};

}  // namespace highwall
