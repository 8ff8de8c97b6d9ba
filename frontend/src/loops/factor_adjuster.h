#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/internal/background_job.h>

#include "loops/map_correction.h"

namespace highwall {

// Brings all keyframes of a world to where the factors of the user's have them (OwnFactors): finds
// the frames they are measured in, and solves the pose graph of keyframes, loops, frames and
// factors. Local adjustments move a few keyframes against those before them, and would let an error
// that grows slowly grow.
//
// What factors have moved, keyframe by keyframe, is remembered, so that the graph's odometry is
// what images have told: were it that of the map as it is, each time would fit the same factors
// once more, and the map would come to follow their noise.
class FactorAdjuster {
 public:
  FactorAdjuster(const OwnFactorOptions& options, const KeyFrameGraphOptions& graph);
  // Work that has not ended is cancelled.
  ~FactorAdjuster();
  FactorAdjuster(const FactorAdjuster&) = delete;
  FactorAdjuster& operator=(const FactorAdjuster&) = delete;

  // What comes with a map takes part, but is not new: the map was adjusted to it when it was made.
  void Adopt(const Map& map);
  // Begins where enough factors have joined the world of the submap since the last time and nothing
  // is under way. loops: that were closed. False where nothing was begun.
  bool Begin(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // The same where any factor is new.
  bool BeginLast(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // Is anything ready to be applied?
  bool HasResult() const;
  // Waits for the work to end and applies it to the map, between frames. Empty where there is none.
  // Throws what ended the work.
  std::optional<FactorAdjustmentReport> Finish(Map* map);
  // Nothing of what is being worked on is applied: the map was moved under it. Does not wait.
  void Cancel();
  // Keyframes of the map have been moved by a loop's graph with factors in it.
  void Remember(const Map& map, KeyFrameMoves by_loop);

 private:
  class Job;
  bool Start(const Map& map, SubmapId submap, std::span<const LoopEdge> loops, std::size_t enough);

  const OwnFactorOptions options_;
  const KeyFrameGraphOptions graph_;
  // Factors that took part last, by the root of their world.
  std::map<SubmapId, std::size_t> adjusted_;
  // T_WC = T_V B: where images alone have the keyframe, and its move B.
  KeyFrameMoves moves_;
  JobSlot<Job> job_;
};

}  // namespace highwall
