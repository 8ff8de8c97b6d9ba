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
#include "loops/map_correction.h"
#include "map/map_matcher.h"

namespace highwall {

struct LoopCorrectionResult {
  bool accepted = false;  // false: the solver failed, or the loop is false; nothing was moved
  std::string message;    // why not, or the solver's words
  MapFusion fusion;       // what was made one
  std::optional<SubmapMerge> merge;  // of submaps that were apart
  KeyFrameMoves by_factors;          // by the graph, where factors of the user's took part in it
  double pose_graph_ms = 0.0, fusion_ms = 0.0;
};

// Closes a loop between keyframes of the map: where the drift allows it (LoopChi2), solves the pose
// graph of the keyframes, robust to loops that are false, moves keyframes and landmarks, and makes
// landmarks one that both sides of the loop have. Submaps that were apart are merged instead: there
// is no drift between them, and nothing to solve for. old_loops: closed before.
LoopCorrectionResult CorrectLoop(std::span<const LoopEdge> old_loops, const Loop& loop,
                                 const MeasurementModel& model,
                                 const KeyFrameGraphOptions& graph_options,
                                 const LoopCorrectionOptions& options, Map* map);

}  // namespace highwall
