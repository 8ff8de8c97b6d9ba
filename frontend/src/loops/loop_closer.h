#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/internal/background_job.h>

#include "loops/loop_correction.h"
#include "loops/loop_detector.h"
#include "map/map_edit.h"
#include "map/map_stage.h"

namespace highwall {

// Closes loops: detects them, corrects the pose graph, fuses duplicate landmarks, adjusts the whole
// map. A new loop cancels an adjustment that still runs after an older one. (Xiao et al. 2025,
// section 2.3.)
class LoopCloser final : public MapStage {
 public:
  // model: must outlive the closer. threads: of the solvers, on a thread of its own; 0: computes
  // before InsertKeyFrame() returns, and the same input gives the same map. bundle: options of the
  // adjustment after a loop. profile: null: none; must outlive the closer.
  explicit LoopCloser(const MeasurementModel& model, const LoopCloserOptions& options = {},
                      int threads = 2, const BundleAdjustmentOptions& bundle = kGlobalAdjustment,
                      RunProfile* profile = nullptr);
  // Cancels work that has not ended.
  ~LoopCloser() override;
  LoopCloser(const LoopCloser&) = delete;
  LoopCloser& operator=(const LoopCloser&) = delete;

  // Looks for a loop of a new keyframe of the map and begins to close it. Returns true if one was
  // found. If too much cancelled work has yet to end, the search is left to the next keyframe.
  // prepare: called if one was found, before the map is copied, because all of it is about to move.
  bool InsertKeyFrame(const Map& map, KeyFrameId keyframe,
                      const std::function<void()>& prepare = {});
  // As InsertKeyFrame(), at the end of a run: LoopDetector::DetectLast of the newest keyframes.
  bool InsertLast(const Map& map, std::span<const KeyFrameId> newest,
                  const std::function<void()>& prepare = {});
  // Returns the loops that InsertKeyFrame() detected but rejected since the last call.
  std::vector<LoopReport> TakeRefused();
  // Returns, once, the moves of keyframes by the graph of the last applied loop, if user factors
  // took part in it.
  KeyFrameMoves TakeMovesByFactors();
  // Returns whether a loop itself, not the adjustment after it, is being closed.
  bool IsClosing() const;
  // Returns whether neither a loop is being closed nor the map adjusted after one.
  bool IsIdle() const override { return job_.IsEmpty(); }
  SubmapId submap() const override;
  // Returns whether a result is ready to be applied.
  bool HasResult() const;
  // Applies the ready results to the map, between frames. MapEdit describes the changes.
  // Rethrows the exception that ended the work, once; nothing is applied then.
  std::vector<LoopReport> Update(Map* map);
  // Waits for the work to end and applies it. Throws as Update().
  std::vector<LoopReport> Finish(Map* map);
  void Drop() override;
  void Forget() override { detector_.Forget(); }
  // The accepted and applied loops.
  const std::vector<LoopEdge>& loops() const { return loops_; }

 private:
  struct Result;
  class Job;

  // Begins to close the loop, if there is one.
  bool Close(const Map& map, std::optional<Loop> loop, const std::function<void()>& prepare);
  // Applies the results of a job.
  std::vector<LoopReport> Take(Job& job, Map* map);

  const MeasurementModel& model_;
  LoopCloserOptions options_;
  const BundleAdjustmentOptions bundle_;
  const int threads_;
  RunProfile* const profile_;
  LoopDetector detector_;
  std::vector<LoopEdge> loops_;
  KeyFrameMoves by_factors_;
  JobSlot<Job> job_;
};

}  // namespace highwall
