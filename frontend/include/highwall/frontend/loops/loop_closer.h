#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/loops/loop_correction.h>
#include <highwall/frontend/loops/loop_detector.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

struct LoopCloserOptions {
  bool enabled = true;
  LoopDetectorOptions detector{};
  LoopCorrectionOptions correction{};
  bool adjust = true;  // the whole map after a loop: global bundle adjustment
  // Few steps: the pose graph has brought the map near, and local adjustments go on.
  BundleAdjustmentOptions bundle{
      .first_iterations = 4, .second_iterations = 4, .tolerance = 1e-4, .trust_region = 1e8};
  // On a thread of its own, on a copy of the map; what comes out is applied between frames. false:
  // before InsertKeyFrame returns; the same input then gives the same map.
  bool background = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
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

// Closes loops: finds them, corrects the pose graph, makes twofold landmarks one, adjusts the whole
// map. A loop that is found while the adjustment after an older one still runs ends that one.
// (Xiao et al. 2025, section 2.3.)
class LoopCloser {
 public:
  // levels: of the ORB pyramid. model: must outlive the closer.
  LoopCloser(const MeasurementModel& model, int levels, const LoopCloserOptions& options = {});
  // Work that has not ended is given up.
  ~LoopCloser();
  LoopCloser(const LoopCloser&) = delete;
  LoopCloser& operator=(const LoopCloser&) = delete;

  // Looks for a loop of a new keyframe of the map and begins to close it. True where one was found.
  bool InsertKeyFrame(const Map& map, KeyFrameId keyframe);
  // Is anything ready to be applied?
  bool HasNews() const;
  // Applies what is ready to the map; between frames. What moves: MapCorrection.
  std::vector<LoopReport> Update(Map* map);
  // Waits for the work to end and applies it.
  std::vector<LoopReport> Finish(Map* map);
  // Nothing of what is being worked on is applied: the map was moved under it. Does not wait.
  void GiveUp();
  // As far as they were accepted and applied.
  const std::vector<LoopEdge>& loops() const { return loops_; }

 private:
  struct Result;
  class Job;

  const MeasurementModel& model_;
  int levels_;
  LoopCloserOptions options_;
  LoopDetector detector_;
  std::vector<LoopEdge> loops_;
  std::unique_ptr<Job> job_;
  std::vector<std::unique_ptr<Job>> ending_;  // given up, their threads still to end
};

}  // namespace highwall
