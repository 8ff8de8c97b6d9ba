#pragma once

#include <span>
#include <string>
#include <vector>

#include <highwall/core/pose_graph.h>
#include <highwall/frontend/loops/keyframe_graph.h>
#include <highwall/frontend/loops/loop_detector.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/loops/map_correction.h>
#include <highwall/frontend/map/map_matcher.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

struct LoopCorrectionOptions {
  KeyFrameGraphOptions graph{};
  RobustLoops robust = RobustLoops::kGnc;
  MapMatcherOptions matcher{};  // of the search for landmarks that are there twice
  int fused_keyframes = 12;     // >= 0: neighbours on either side of the loop that take part
  int threads = 2;              // >= 1: of the solver; 1 gives bit-equal results on every run

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct LoopCorrectionResult {
  bool accepted = false;  // false: the solver failed, or the loop is false; nothing was moved
  std::string message;    // why not, or the solver's words
  MapFusion fusion;       // what was made one
  double pose_graph_ms = 0.0, fusion_ms = 0.0;
};

// Closes a loop between keyframes of the map: where the drift allows it (LoopChi2), solves the pose
// graph of the keyframes, robust to loops that are false, moves keyframes and landmarks, and makes
// landmarks one that both sides of the loop have. old_loops: closed before. levels: of the ORB
// pyramid.
LoopCorrectionResult CorrectLoop(std::span<const LoopEdge> old_loops, const Loop& loop,
                                 const MeasurementModel& model, int levels,
                                 const LoopCorrectionOptions& options, Map* map);

}  // namespace highwall
