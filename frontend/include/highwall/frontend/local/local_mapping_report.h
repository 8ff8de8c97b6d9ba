#pragma once

#include <vector>

#include <highwall/frontend/map/map_ids.h>

namespace highwall {

struct BundleAdjustmentReport {
  int keyframes = 0, fixed_keyframes = 0, points = 0, lines = 0;
  int observations = 0, outliers = 0;
  int imu_factors = 0;
  double initial_cost = 0.0, final_cost = 0.0;
  bool usable = false;  // false: the solver failed and the map was not touched
};

struct LocalMappingReport {
  KeyFrameId keyframe = kNoId;
  BundleAdjustmentReport bundle;  // in the background: what Update() returns instead
  int new_points = 0, new_lines = 0, fused_points = 0;
  int triangulated_points = 0, triangulated_lines = 0;  // not among the new: they had no depth
  int culled_points = 0, culled_lines = 0;
  std::vector<KeyFrameId> culled_keyframes;
};

}  // namespace highwall
