#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/internal/background_job.h>

#include "map/map_edit.h"
#include "map/map_stage.h"

namespace highwall {

// Adjusts all keyframes of a world to the user (external) factors (UserFactors): estimates the
// frames they are measured in, and solves the pose graph of keyframes, loops, frames and factors.
// Local adjustments move a few keyframes against earlier ones, and would not stop a slowly growing
// error.
//
// The moves of keyframes by factors are stored, so that the graph's odometry is that of the images
// alone: if it were that of the current map, each adjustment would fit the same factors again, and
// the map would gradually follow their noise.
class FactorAdjuster final : public MapStage {
 public:
  // model: must outlive it. threads, profile: as of LoopCloser.
  FactorAdjuster(const MeasurementModel& model, const UserFactorOptions& options,
                 const KeyFrameGraphOptions& graph, int threads = 2, RunProfile* profile = nullptr);
  // Cancels work that has not ended.
  ~FactorAdjuster() override;
  FactorAdjuster(const FactorAdjuster&) = delete;
  FactorAdjuster& operator=(const FactorAdjuster&) = delete;

  // Registers the factors of a loaded map: they take part, but are not new, as the map is already
  // adjusted to them.
  void Adopt(const Map& map);
  // Begins if enough factors have been added to the world of the submap since the last time and no
  // job is running. loops: the closed ones. Returns false if nothing was begun.
  bool Begin(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // Does the same if any factor is new.
  bool BeginLast(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);
  // Returns whether a result is ready to be applied.
  bool HasResult() const;
  // Waits for the work to end and applies it to the map, between frames. Empty if there is none.
  // Rethrows the exception that ended the work.
  std::optional<FactorAdjustmentReport> Finish(Map* map);
  bool IsIdle() const override { return job_.IsEmpty(); }
  SubmapId submap() const override;
  void Drop() override;
  // Adds moves of keyframes by the pose graph of a loop with factors in it.
  void Remember(const Map& map, KeyFrameMoves by_loop);

 private:
  class Job;
  void MarkAdjusted(std::span<const std::size_t> numbers);
  bool Start(const Map& map, SubmapId submap, std::span<const LoopEdge> loops);

  const MeasurementModel& model_;
  const UserFactorOptions options_;
  const KeyFrameGraphOptions graph_;
  const int threads_;
  RunProfile* const profile_;
  // By MapFactor::number: whether the factor has been adjusted. Worlds may have been merged since.
  std::vector<bool> adjusted_;
  // T_WC = T_V B: pose T_V of the keyframe by images alone, and its move B.
  KeyFrameMoves moves_;
  JobSlot<Job> job_;
};

}  // namespace highwall
