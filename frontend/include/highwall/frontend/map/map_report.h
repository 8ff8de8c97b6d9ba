#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map_ids.h>

// What adjustments, local mapping and loops have made of the map.
namespace [[gnu::visibility("default")]] highwall {

// What became of an adjustment.
struct BundleAdjustmentReport {
  int keyframes = 0, fixed_keyframes = 0, points = 0, lines = 0;
  int observations = 0, outliers = 0;
  int imu_factors = 0;
  int own_factors = 0;            // of the user's
  int own_factors_set_aside = 0;  // of the user's, which cannot be evaluated where the map has them
  double initial_cost = 0.0, final_cost = 0.0;
  int rejected_steps = 0;  // that led up, or where an observation cannot be: behind the camera
  bool moved = false;      // false: no step was taken, all is as it was
  bool usable = false;   // false: the solver failed, or it was refused, and the map was not touched
  bool refused = false;  // more than a third of the observations would have been forgotten
  std::string message{};  // why it is not usable
};

// What a new keyframe changed in the map.
struct LocalMappingReport {
  KeyFrameId keyframe = kNoId;
  BundleAdjustmentReport bundle;  // in the background: what Update() returns instead
  int new_points = 0, new_lines = 0, fused_points = 0;
  int triangulated_points = 0, triangulated_lines = 0;  // not among the new: they had no depth
  int culled_points = 0, culled_lines = 0;
  std::vector<KeyFrameId> culled_keyframes;
};

// Where a keyframe was seen to be from another one that the map did not connect it with.
struct LoopEdge {
  KeyFrameId match = kNoId;     // the older one
  KeyFrameId keyframe = kNoId;  // the newer one
  Pose Z;                       // measured T_match_keyframe
};

// Two submaps that were found to show one place.
struct SubmapMerge {
  SubmapId root = kNoId;   // that both are named by from now on
  SubmapId other = kNoId;  // root of the younger until now
  SubmapId moved = kNoId;  // the one of the two whose world frame is given up
  Pose T_new_old;          // from that to the one that stays
};

// A place seen again.
struct Loop {
  LoopEdge edge;
  std::vector<std::pair<int, PointId>> points{};  // feature of edge.keyframe -> landmark of old
  std::vector<std::pair<int, LineId>> lines{};
  double chi2 = 0.0;  // of the correction against the drift that is thought possible; 0 of a merge
};

// What became of a loop, or of the adjustment after one.
struct LoopReport {
  Loop loop;
  bool accepted = false;  // false: it was found false; nothing was moved
  std::string message{};  // the solver's words, or the test that refused it with its figure
  // Where the loop joined two submaps, in its first report.
  std::optional<SubmapMerge> merge{};
  // Present when the adjustment is done, in a report of its own.
  std::optional<BundleAdjustmentReport> bundle{};
  int fused_points = 0, fused_lines = 0;
  double seconds = 0.0;  // from the detection of the loop to the result
};

// What the factors of the user's have made of all keyframes of a world.
struct FactorAdjustmentReport {
  bool accepted = false;  // false: nothing was moved
  std::string message{};  // the solver's words, or why not
  int keyframes = 0, factors = 0;
  int set_aside = 0;    // factors that cannot be evaluated where the map has their bodies
  std::string fault{};  // what the first of them throws, or what else is wrong with it
  double moved = 0.0;   // [m] the largest way of a keyframe
  double seconds = 0.0;
};

}  // namespace highwall
