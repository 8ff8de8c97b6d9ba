#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/calibration/options.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/internal/background_job.h>

#include "map/map_stage.h"

namespace highwall {

// Estimates the depth distortion over the image online, from a growing map (CalibrateCamera), and
// the map after its correction: features of keyframes, with its whole world adjusted to them.
// (docs/calibration.md, While tracking)
class DepthDistortionEstimator final : public MapStage {
 public:
  // camera: with its distortion. bundle: options of the adjustment of a corrected map. threads: of
  // its solver, on a thread of its own; 0: computes before Begin() returns. profile: null: none;
  // must outlive the estimator.
  DepthDistortionEstimator(const PinholeCamera& camera, const DepthPatternOptions& options,
                           const BundleAdjustmentOptions& bundle, int threads = 2,
                           RunProfile* profile = nullptr);
  // Requests a stop of work that has not ended, and waits for it.
  ~DepthDistortionEstimator() override;
  DepthDistortionEstimator(const DepthDistortionEstimator&) = delete;
  DepthDistortionEstimator& operator=(const DepthDistortionEstimator&) = delete;

  // The pattern to correct the depth of images with from now on.
  const DepthPattern& pattern() const { return pattern_; }

  // Begins if the world of the submap has grown by enough since the last time and no job is
  // running. given: keyframes up to this one came with the map and stay as they are.
  void Begin(const Map& map, const MeasurementModel& model, SubmapId submap, KeyFrameId given);
  // Returns whether a pattern was found and is ready to be applied.
  bool HasResult() const;
  // Waits for the work to end and applies it to the map, between frames: if a pattern was found,
  // corrects the keyframes of this run and moves those of the world to their adjusted poses.
  // Returns whether a pattern was found. Rethrows the exception that ended the work.
  bool Finish(Map* map);
  // A finished search that found nothing counts as idle.
  bool IsIdle() const override;
  SubmapId submap() const override;
  void Drop() override;

 private:
  class Job;

  const PinholeCamera camera_;
  const DepthPatternOptions options_;
  const BundleAdjustmentOptions bundle_;
  const int threads_;
  RunProfile* const profile_;
  DepthPattern pattern_;
  std::optional<double> sigma_;  // [1/m] RMS of the standard deviations of the estimated pattern
  std::size_t next_;             // keyframes of a world at which the next search begins
  JobSlot<Job> job_;
};

}  // namespace highwall
