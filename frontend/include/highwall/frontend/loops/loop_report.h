#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/local/local_mapping_report.h>
#include <highwall/frontend/map/map_ids.h>

namespace highwall {

// Where a keyframe was seen to be from another one that the map did not connect it with.
struct LoopEdge {
  KeyFrameId match = kNoId;     // the older one
  KeyFrameId keyframe = kNoId;  // the newer one
  Pose Z;                       // measured T_match_keyframe
};

// A place seen again.
struct Loop {
  LoopEdge edge;
  std::vector<std::pair<int, PointId>> points;  // feature of edge.keyframe -> landmark of old
  std::vector<std::pair<int, LineId>> lines;
  double chi2 = 0.0;  // of the correction against the drift that is thought possible
};

// What became of a loop, or of the adjustment after one.
struct LoopReport {
  Loop loop;
  bool accepted = false;  // false: the pose graph called it false; nothing was moved
  std::string message;    // the solver's words
  // Present when the adjustment is done, in a report of its own.
  std::optional<BundleAdjustmentReport> bundle;
  int fused_points = 0, fused_lines = 0;
  double seconds = 0.0;  // from the detection of the loop to the result
};

}  // namespace highwall
