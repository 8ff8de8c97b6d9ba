#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>
#include <highwall/internal/background_job.h>

#include "features/depth_grid.h"
#include "features/row_times.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// What of a camera's images is known by now.
struct ImageKnowledge {
  std::optional<FrameTiming> timing{};  // empty where images are taken to be of one time
  DepthPattern pattern{};               // of depth, found while tracking
};

// Poses of frames found once more when the map about them has grown and been adjusted: against
// landmarks that were not there yet, with the depth as it would be mended now, and with rows moved
// by the motion from the frame before to the one after. Of those that images alone tell; keyframes
// are the adjustments' affair. Works on copies, some frames at a time. (docs/tracking.md)
class FrameRefiner {
 public:
  // model: must outlive the refiner. camera: with its distortion.
  FrameRefiner(const MeasurementModel& model, const PinholeCamera& camera,
               const FrameRefinementOptions& options, const TrackerOptions& tracker);
  // Work that has not ended is cancelled.
  ~FrameRefiner();
  FrameRefiner(const FrameRefiner&) = delete;
  FrameRefiner& operator=(const FrameRefiner&) = delete;

  // A frame with its pose, in the order of their stamps. moved_by: its rows. pattern: that its
  // depth was mended by. newest: the newest keyframe.
  void Add(const TrackedFrame& frame, const PosedFrame& posed, const RowMotion& moved_by,
           const DepthPattern& pattern, KeyFrameId newest);
  // Begins where enough frames have waited long enough and nothing is under way.
  void Begin(const Map& map, const ImageKnowledge& knowledge);
  // Is anything ready to be applied?
  bool HasResult() const;
  // Waits for the work to end and applies it: frames that are among `frames`, ascending by stamp,
  // get their new poses. Throws what ended the work.
  void Finish(const Map& map, std::vector<PosedFrame>* frames);
  // The same for all that wait.
  void FinishAll(const Map& map, const ImageKnowledge& knowledge, std::vector<PosedFrame>* frames);
  // How many poses were found once more.
  int refined() const { return refined_; }

 private:
  struct Item;
  class Job;

  void Start(const Map& map, const ImageKnowledge& knowledge, std::size_t count);

  const MeasurementModel& model_;
  const PinholeCamera camera_;
  const DepthGrid grid_;
  const FrameRefinementOptions options_;
  const TrackerOptions tracker_;
  std::vector<Item> waiting_;
  std::optional<PosedFrame> before_;  // the frame before those that wait
  KeyFrameId newest_ = kNoId;
  int refined_ = 0;
  JobSlot<Job> job_;
};

}  // namespace highwall
