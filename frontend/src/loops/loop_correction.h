#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <highwall/core/pose_graph.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "loops/keyframe_graph.h"
#include "loops/loop_detector.h"
#include "map/map_edit.h"
#include "map/map_matcher.h"

namespace highwall {

struct LoopCorrectionResult {
  bool accepted = false;  // false: the solver failed, or the loop is false; nothing was moved
  std::string message;    // the reason, or the solver's message
  MapFusion fusion;       // the fused landmarks
  std::optional<SubmapMerge> merge;  // of unconnected submaps
  KeyFrameMoves by_factors;          // moves by the graph, if user factors took part in it
};

// Closes a loop between keyframes of the map: if it is consistent with the drift (LoopChi2), solves
// the pose graph of the keyframes, robust to false loops, moves keyframes and landmarks, and fuses
// landmarks common to both sides of the loop. Unconnected submaps are merged instead: there is no
// drift between them, and no graph to solve. old_loops: those closed before. threads: >= 1, of the
// solver; with more than one the last bits vary from run to run.
LoopCorrectionResult CorrectLoop(std::span<const LoopEdge> old_loops, const Loop& loop,
                                 const MeasurementModel& model,
                                 const KeyFrameGraphOptions& graph_options,
                                 const LoopCorrectionOptions& options, Map* map, int threads = 1);

}  // namespace highwall
