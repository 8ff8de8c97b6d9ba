#pragma once

#include <initializer_list>
#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "sensor/sensor_model.h"
#include "tracking/dynamic_features.h"
#include "tracking/frame_solver.h"
#include "tracking/landmark_observations.h"
#include "tracking/last_frame_source.h"
#include "tracking/pose_hypothesis.h"
#include "tracking/pose_verifier.h"
#include "tracking/recognition_sources.h"
#include "tracking/relocalizer.h"
#include "tracking/tracked_frame.h"
#include "tracking/tracker_parameters.h"
#include "tracking/tracker_state.h"
#include "tracking/whole_image_source.h"

namespace highwall {

class RunProfile;

// Result of Tracker::Track. The caller applies what concerns the map and the sensor.
struct TrackingResult {
  TrackedFrame frame{};
  LandmarkCounts counts{};
  std::optional<FrameMotion> motion{};  // for the sensor; empty if it is not continuous
};

// Returns what the sensor model of a tracker estimates.
SensorModelOptions SensorOptions(const TrackerOptions& options);

// Tracks the camera pose frame by frame: prediction by an IMU or at constant velocity, matching of
// the last frame's landmarks by projection, pose by SolvePose, then the same with the landmarks of
// the local map. Falls back on descriptor matching with the reference keyframe, then on
// relocalization. (Xiao et al. 2025, figure 2, tracking.)
class Tracker {
 public:
  // model, sensor, profile (null: none): must outlive the tracker.
  Tracker(const MeasurementModel& model, const TrackerOptions& options, const SensorModel& sensor,
          const TrackerParameters& parameters = {}, RunProfile* profile = nullptr);
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  // Tracks a frame. The features of `frame` are as its rows observed them; those of the result are
  // compensated to the time of the middle row. predicted: the pose predicted by the IMU, if
  // available.
  TrackingResult Track(const Frame& frame, const Map& map,
                       const std::optional<PoseConstraint>& predicted = std::nullopt);

  // Makes `tracked`, which became the keyframe, the last frame: its landmarks, new ones included,
  // are the ones the next frame is matched to, from its pose after the adjustment.
  void Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe);
  // Extrapolates the pose at constant velocity from the last frame; empty if lost, or if the last
  // frame is too old. Does not replace the last frame.
  std::optional<TrackedFrame> ExtrapolateAtConstantVelocity(const Frame& frame) const;
  // Drops the last frame, because the following frames are of another world.
  void Forget() { state_.last.reset(); }
  // Sets the final pose of the last frame.
  void Correct(const Pose& T_WC);
  // Returns the keyframe that the last tracked frame shares most landmarks with; empty if lost.
  std::optional<KeyFrameId> reference() const;
  // Returns the dynamic mask of a keyframe, by the depth of the seconds before and since.
  cv::Mat DynamicMaskOf(const KeyFrame& keyframe, const Map& map) const;
  // Returns the motion expected at the next frame: that of `predicted`, or the last one; zero if
  // the camera was lost.
  Twist Motion(const PoseConstraint* predicted) const { return state_.Motion(predicted); }
  // Motion by which the rows of the latest frame were compensated.
  const RowMotion& moved_by() const { return moved_by_; }
  // Mean match ratio (TrackedFrame::found) of the latest frames; 0: unknown.
  double usual_match_ratio() const { return state_.mean_match_ratio; }
  // Follows a map that was transformed around here: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);

 private:
  // Searches the pose of a frame by the hypotheses in their order: from the last frame, by the
  // prediction and without it; by recognition of the place; by surfaces; by the whole image.
  PoseSearch Find(const TrackingQuery& query) const;
  // Verifies the hypotheses of those sources that are due.
  void Try(std::initializer_list<const PoseSource*> sources, const TrackingQuery& query,
           PoseSearch* search) const;
  // Name of the stage of a source in the trace of a run.
  const char* StageOf(const PoseSource* source) const;
  // Returns whether the prediction gives no pose, or one whose motion is implausible for a camera:
  // the IMU may have measured an impact on the sensor.
  bool IsPredictionSuspect(const TrackingQuery& query, const PoseSearch& search) const;
  // Updates the motion by a frame tracked from the last one, and returns it; empty if it is not
  // continuous. query: without the prediction if that was rejected.
  std::optional<FrameMotion> UpdateMotion(const TrackingQuery& query, LocalMatch* match);
  // Replaces the expected motion in the compensation of the features by the estimated one, and
  // re-estimates the pose.
  void FollowMotion(const TrackingQuery& query, TrackedFrame* tracked);

  const MeasurementModel& model_;
  const SensorModel& sensor_;
  TrackerOptions options_;
  TrackerParameters parameters_;
  RunProfile* const profile_;
  TrackerState state_;
  MapMatcher matcher_;
  Relocalizer relocalizer_;
  Relocalizer reference_matcher_;
  DynamicFeatures moving_;
  FrameSolver solver_;
  PoseVerifier verifier_;
  // The sources of hypotheses.
  LastFrameSource last_frame_;
  ReferenceKeyframeSource reference_keyframe_;
  PlaceIndexSource place_index_;
  SurfaceSource surfaces_;
  WholeImageSource whole_image_;
  bool imu_predicts_motion_ = false;    // whether an IMU predicted the motion at the last frame
  RowMotion moved_by_;                  // compensation of the features of the latest frame
  std::optional<KeyFrameId> anchored_;  // keyframe made of the last frame, if by images alone
};

}  // namespace highwall
