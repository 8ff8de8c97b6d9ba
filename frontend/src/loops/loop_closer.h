#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/internal/background_job.h>

#include "local/bundle_adjustment.h"
#include "loops/loop_correction.h"
#include "loops/loop_detector.h"
#include "loops/map_correction.h"

namespace highwall {

// Closes loops: finds them, corrects the pose graph, makes twofold landmarks one, adjusts the whole
// map. A loop that is found while the adjustment after an older one still runs ends that one.
// (Xiao et al. 2025, section 2.3.)
class LoopCloser {
 public:
  // model: must outlive the closer.
  explicit LoopCloser(const MeasurementModel& model, const LoopCloserOptions& options = {});
  // Work that has not ended is cancelled.
  ~LoopCloser();
  LoopCloser(const LoopCloser&) = delete;
  LoopCloser& operator=(const LoopCloser&) = delete;

  // Looks for a loop of a new keyframe of the map and begins to close it. True where one was found.
  // Where too much that was cancelled has yet to end, the next keyframe looks.
  // prepare: called where one was found, before the map is copied: all of it is about to move.
  bool InsertKeyFrame(const Map& map, KeyFrameId keyframe,
                      const std::function<void()>& prepare = {});
  // What InsertKeyFrame() saw and did not believe, since the last call.
  std::vector<LoopReport> TakeRefused();
  // How the graph of the loop that was applied last moved keyframes, once, where factors of the
  // user's took part in it.
  KeyFrameMoves TakeMovesByFactors();
  // A loop itself, not the adjustment after it, is being closed.
  bool IsClosing() const;
  // Neither is a loop being closed, nor the map adjusted after one.
  bool IsIdle() const { return job_.IsEmpty(); }
  // Is anything ready to be applied?
  bool HasResult() const;
  // Applies what is ready to the map; between frames. What moves: MapCorrection. Throws what ended
  // the work, once; nothing is applied then.
  std::vector<LoopReport> Update(Map* map);
  // Waits for the work to end and applies it. Throws as Update().
  std::vector<LoopReport> Finish(Map* map);
  // Nothing of what is being worked on is applied: the map was moved under it. Does not wait.
  void Cancel();
  // As far as they were accepted and applied.
  const std::vector<LoopEdge>& loops() const { return loops_; }

 private:
  struct Result;
  class Job;

  // Applies what has come out of a job.
  std::vector<LoopReport> Take(Job& job, Map* map);

  const MeasurementModel& model_;
  LoopCloserOptions options_;
  LoopDetector detector_;
  std::vector<LoopEdge> loops_;
  KeyFrameMoves by_factors_;
  JobSlot<Job> job_;
};

}  // namespace highwall
