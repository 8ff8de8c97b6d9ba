#pragma once

#include <optional>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/map_ids.h>

// Reports of adjustments, local mapping and loop closures.
namespace [[gnu::visibility("default")]] highwall {

// Result of a bundle adjustment.
struct BundleAdjustmentReport {
  int keyframes = 0, fixed_keyframes = 0, points = 0, lines = 0;
  int observations = 0, outliers = 0;
  int imu_factors = 0;
  int user_factors = 0;  // user factors
  // user factors excluded because they cannot be evaluated at the current poses
  int user_factors_excluded = 0;
  double initial_cost = 0.0, final_cost = 0.0;
  int rejected_steps = 0;  // that increased the cost or moved an observation behind the camera
  bool moved = false;      // false: no step was taken, nothing changed
  // false: the solver failed, or the result was refused, and the map was not changed
  bool usable = false;
  bool refused = false;   // more than a third of the observations would have been removed
  std::string message{};  // why it is not usable
};

// Changes of the map by a new keyframe.
struct LocalMappingReport {
  KeyFrameId keyframe = kNoId;
  BundleAdjustmentReport bundle;  // in the background: the one that Update() returns
  int new_points = 0, new_lines = 0, fused_points = 0;
  int triangulated_points = 0, triangulated_lines = 0;  // not included in new_*: they had no depth
  int culled_points = 0, culled_lines = 0;
  std::vector<KeyFrameId> culled_keyframes;
};

// Measured relative pose of two keyframes that the map did not connect before.
struct LoopEdge {
  KeyFrameId match = kNoId;     // the older one
  KeyFrameId keyframe = kNoId;  // the newer one
  Pose Z;                       // measured T_match_keyframe
  // Covariance [m^2, rad^2] of Z by the landmarks that matched: of a translation and a rotation
  // along the axes of the camera of `keyframe`.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

// Two submaps that were recognized to overlap.
struct SubmapMerge {
  SubmapId root = kNoId;   // root of both from now on
  SubmapId other = kNoId;  // root of the younger one until now
  SubmapId moved = kNoId;  // the one of the two whose world frame is discarded
  Pose T_new_old;          // from that frame to the remaining one
};

// A revisited place.
struct Loop {
  LoopEdge edge;
  PerKind<LandmarkMatches> matches{};  // feature of edge.keyframe -> older landmark
  double chi2 = 0.0;  // of the correction against the expected drift; 0 for a merge
};

// Result of a loop closure, or of the adjustment after it.
struct LoopReport {
  Loop loop;
  bool accepted = false;  // false: it was rejected; nothing was moved
  std::string message{};  // the solver's message, or the test that rejected it with its value
  // Set if the loop merged two submaps, in its first report.
  std::optional<SubmapMerge> merge{};
  // Set when the adjustment is complete, in a report of its own.
  std::optional<BundleAdjustmentReport> bundle{};
  int fused_points = 0, fused_lines = 0;
  double seconds = 0.0;  // from the detection of the loop to the result
};

// Result of adjusting all keyframes of a world to the user factors.
struct FactorAdjustmentReport {
  bool accepted = false;  // false: nothing was moved
  std::string message{};  // the solver's message, or the reason
  int keyframes = 0, factors = 0;
  int excluded = 0;     // factors excluded because they cannot be evaluated at the current poses
  std::string fault{};  // exception of the first of them, or its other fault
  double moved = 0.0;   // [m] largest displacement of a keyframe
  double seconds = 0.0;
};

}  // namespace highwall
