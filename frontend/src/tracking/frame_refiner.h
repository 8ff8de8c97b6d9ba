#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_report.h>
#include <highwall/frontend/tracking/options.h>
#include <highwall/internal/background_job.h>

#include "features/depth_grid.h"
#include "features/row_times.h"
#include "tracking/lost_frame.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Current estimate of the properties of a camera's images.
struct ImageKnowledge {
  std::optional<FrameTiming> timing{};   // empty where row times are ignored
  DepthPattern pattern{};                // depth distortion, estimated online
  std::optional<NoiseEstimate> noise{};  // of features; empty where it is not estimated
};

// Parameters of FrameRefiner that are no options of a user.
struct FrameRefinerParameters {
  int keyframes = 10;  // >= 0: keyframes created since a frame
  // >= 1: with rolling shutter, the motion between frames is re-estimated per round
  int rounds = 3;
};

// Non-keyframe refinement: re-estimates poses of frames after the map around them has grown and
// been adjusted, against landmarks that did not exist before, with the depth corrected by the
// current estimate, and with rolling-shutter compensation by the motion from the preceding to the
// following frame. Of frames with an IMU it is the pose by the image alone that is refined;
// keyframes are left to the adjustments. Works on copies, in batches of frames. (docs/tracking.md)
class FrameRefiner {
 public:
  // model: must outlive the refiner. camera: with its distortion. background: on a thread of its
  // own, otherwise within Begin(). profile: null: none; must outlive the refiner.
  FrameRefiner(const MeasurementModel& model, const PinholeCamera& camera,
               const FrameRefinementOptions& options, const TrackerOptions& tracker,
               bool background = true, const FrameRefinerParameters& parameters = {},
               RunProfile* profile = nullptr);
  // Cancels work that has not ended.
  ~FrameRefiner();
  FrameRefiner(const FrameRefiner&) = delete;
  FrameRefiner& operator=(const FrameRefiner&) = delete;

  // Adds a frame with its pose; frames come in the order of their stamps. moved_by: motion its rows
  // were compensated by. pattern: depth distortion its depth was corrected by. newest: the newest
  // keyframe.
  void Add(const TrackedFrame& frame, const PosedFrame& posed, const RowMotion& moved_by,
           const DepthPattern& pattern, KeyFrameId newest);
  // Removes the frame with this stamp, whose submap will be dropped; empty if none waits whose
  // features are kept.
  std::optional<LostFrame> Withdraw(Stamp stamp);
  // Returns whether more frames wait than FrameRefinementOptions::waiting.
  bool IsFull() const;
  // Begins if enough frames have waited long enough and no job is running.
  void Begin(const Map& map, const ImageKnowledge& knowledge);
  // Returns whether a result is ready to be applied.
  bool HasResult() const;
  // Waits for the job to end and applies its result: frames that are among `frames`, ascending by
  // stamp, get their new poses. Rethrows the exception that ended the job.
  void Finish(const Map& map, std::vector<PosedFrame>* frames);
  // Does the same for all frames that wait.
  void FinishAll(const Map& map, const ImageKnowledge& knowledge, std::vector<PosedFrame>* frames);
  // Of the features of the frames that wait.
  std::size_t MemoryBytes() const;
  // Number of poses that were refined.
  int refined() const { return refined_; }

 private:
  struct Item;
  class Job;

  void Start(const Map& map, const ImageKnowledge& knowledge, std::size_t count);

  const MeasurementModel& model_;
  const PinholeCamera camera_;
  const DepthGrid grid_;
  const FrameRefinementOptions options_;
  const FrameRefinerParameters parameters_;
  const TrackerOptions tracker_;
  const bool background_;
  RunProfile* const profile_;
  std::vector<Item> waiting_;
  std::optional<PosedFrame> before_;  // the frame preceding those in waiting_
  KeyFrameId newest_ = kNoId;
  int refined_ = 0;
  JobSlot<Job> job_;
};

}  // namespace highwall
