#pragma once

#include <memory>
#include <optional>
#include <span>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_report.h>

#include "features/depth_grid.h"
#include "features/row_times.h"
#include "sensor/frame_timing_estimator.h"
#include "sensor/keyframe_row_times.h"
#include "sensor/noise_estimator.h"

namespace highwall {

// What SensorModel estimates.
struct SensorModelOptions {
  bool has_row_times = true;     // false: global shutter; depth is taken at the stamp of its image
  bool estimates_timing = true;  // false: the row times are the known ones
  bool estimates_noise = true;   // false: the noise is that of the MeasurementModel
};

// Motion of the camera at a tracked frame that it reached without a jump.
struct FrameMotion {
  Twist at_frame;
  // The motion at an earlier keyframe, which the step since has improved; kNoId: none.
  KeyFrameId keyframe = kNoId;
  Twist at_keyframe{};
};

// The sensor as it is estimated while tracking: the noise of its observations (docs/noise.md) and
// the times of its rows (docs/row_times.md), with the compensation that each keyframe was made
// with.
class SensorModel {
 public:
  // model: must outlive it. timing: initial value, if known.
  SensorModel(const MeasurementModel& model, const SensorModelOptions& options,
              const FrameTiming& timing = {});
  SensorModel(const SensorModel&) = delete;
  SensorModel& operator=(const SensorModel&) = delete;

  // Returns the features with the current noise estimate; the same ones if it is not estimated.
  std::shared_ptr<const FrameFeatures> WithNoise(
      const std::shared_ptr<const FrameFeatures>& features) const;
  const NoiseEstimate& noise() const { return noise_.estimate(); }
  bool estimates_noise() const { return options_.estimates_noise; }
  // Updates it from keyframes after an adjustment. While the map is young, of ten keyframes at
  // most, all keyframes after `given` get the new estimate (as new features), the refined corners
  // that of detected ones: the first keyframes came before any estimate. No job may be working on
  // the map. given: the last keyframe of a map that was loaded; kNoId: none.
  void LearnNoise(std::span<const KeyFrameId> keyframes, KeyFrameId given, Map* map);

  // Current estimate of the row times of images.
  const FrameTiming& timing() const { return timing_.timing(); }
  FrameTimingEstimate timing_estimate() const { return timing_.estimate(); }
  // Returns the row times of the images of one frame; empty if they are all zero or ignored.
  std::optional<FrameTiming> TimingOf(const Frame& frame) const;
  // Updates them from a tracked frame, its features compensated by TimingOf.
  void LearnTiming(const FrameTimingEstimator::View& view, const Map& map,
                   const FrameMotion& motion);

  // Stores the motion by which the rows of a new keyframe were compensated.
  void Remember(const KeyFrame& keyframe, const RowMotion& moved_by);
  // Updates it by the readings of an IMU, and takes that back for all keyframes. They follow when
  // they are compensated the next time.
  void CorrectMotion(KeyFrameId keyframe, const Twist& by_readings);
  void ForgetReadings() { keyframe_times_.ForgetReadings(); }
  // Returns that of a keyframe; null if it is not of this run.
  const RowMotion* RowsOf(KeyFrameId keyframe) const { return keyframe_times_.Find(keyframe); }
  // Updates keyframes and their landmarks if the estimate of their row times has changed; their
  // poses are left to the adjustment that follows. Updates the keyframes that share most of these
  // landmarks, at most `most`, or all.
  void CompensateAround(const PerKind<LandmarkIds>& landmarks, int most, Map* map);
  void CompensateAll(Map* map);

 private:
  void Compensate(std::span<const KeyFrameId> keyframes, Map* map);

  SensorModelOptions options_;
  DepthGrid grid_;
  KeyframeRowTimes keyframe_times_;
  FrameTimingEstimator timing_;
  NoiseEstimator noise_;
};

}  // namespace highwall
