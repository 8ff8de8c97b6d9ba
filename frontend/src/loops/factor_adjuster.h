#pragma once

#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>

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

  // Begins where enough factors have joined the map since the last time and nothing is under way.
  // loops: that were closed. False where nothing was begun.
  bool Begin(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // The same where any factor is new.
  bool BeginLast(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // Is anything ready to be applied?
  bool HasResult() const;
  // Waits for the work to end and applies it to the map, between frames. Empty where there is none.
  // Throws what ended the work.
  std::optional<FactorAdjustmentReport> Finish(Map* map);
  // Nothing of what is being worked on is applied: the map was moved under it.
  void Cancel();

 private:
  class Job;
  // T_WC = T_V B: where images alone have the keyframe, and the move by factors, in the camera.
  using Moves = std::unordered_map<KeyFrameId, Pose>;

  // Keyframes that are new were tracked where those before them had been moved to.
  void Inherit(const Map& map);
  bool Start(const Map& map, SubmapId submap, std::span<const LoopEdge> loops, std::size_t enough);

  const OwnFactorOptions options_;
  const KeyFrameGraphOptions graph_;
  std::size_t adjusted_ = 0;  // factors of the map that took part last
  Moves moves_;
  std::unique_ptr<Job> job_;
};

}  // namespace highwall
