#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "pose/degeneracy.h"
#include "pose/direct_alignment.h"
#include "pose/surface_matcher.h"
#include "sensor/sensor_model.h"
#include "tracking/constant_velocity.h"
#include "tracking/dynamic_features.h"
#include "tracking/landmark_observations.h"
#include "tracking/relocalizer.h"
#include "tracking/tracked_frame.h"

namespace highwall {

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
  // model, sensor: must outlive the tracker.
  Tracker(const MeasurementModel& model, const TrackerOptions& options, const SensorModel& sensor);
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
  void Forget() { last_.reset(); }
  // Sets the final pose of the last frame.
  void Correct(const Pose& T_WC);
  // Returns the keyframe that the last tracked frame shares most landmarks with; empty if lost.
  std::optional<KeyFrameId> reference() const;
  // Returns the dynamic mask of a keyframe, by the depth of the seconds before and since.
  cv::Mat DynamicMaskOf(const KeyFrame& keyframe, const Map& map) const;
  // Returns the motion expected at the next frame: that of `predicted`, or the last one; zero if
  // the camera was lost.
  Twist Motion(const PoseConstraint* predicted) const;
  // Motion by which the rows of the latest frame were compensated.
  const RowMotion& moved_by() const { return moved_by_; }
  // Follows a map that was transformed around here: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);

 private:
  // Fallback constraint on a pose, in addition to points and lines.
  enum class FallbackConstraint { kNone, kSurfaces };

  // Returns whether the camera may have come here by continuous motion; otherwise twists are
  // meaningless.
  bool IsContinuous(const Twist& expected, const TrackedFrame& tracked) const;
  // Updates the motion by a frame tracked from the last one, and returns it; empty if it is not
  // continuous. predicted: null if it was rejected.
  std::optional<FrameMotion> UpdateMotion(const PoseConstraint* predicted, bool has_landmarks,
                                          const Map& map, TrackedFrame* tracked);
  // Replaces the expected motion in the compensation of the features by the estimated one, and
  // re-estimates the pose.
  void FollowMotion(const Map& map, const PoseConstraint* predicted, TrackedFrame* tracked);
  // Returns the predicted image shift [px] until `frame` at constant velocity.
  double Shift(const Frame& frame) const;
  // Returns the time [s] from the last frame tracked to `frame`.
  double SinceLast(const Frame& frame) const;
  std::optional<TrackedFrame> TrackMotion(const Frame& frame, const Map& map,
                                          const PoseConstraint* predicted,
                                          FallbackConstraint fallback,
                                          TrackingDiagnostics* diagnostics) const;
  std::optional<TrackedFrame> TrackReference(const Frame& frame, const Map& map) const;
  std::optional<TrackedFrame> Relocalize(const Frame& frame, const Map& map) const;
  // A frame matched with the local map, and the landmarks predicted to be visible from its pose.
  struct LocalMatch {
    TrackedFrame frame;
    LandmarksInView in_view;
    bool prediction_rejected = false;  // found inconsistent with the prediction

    int Support() const;
    std::size_t SupportInView() const;
  };
  // Finds the pose of a frame: from the last one, by relocalization, with surfaces as a fallback
  // constraint, or by direct alignment. diagnostics: why there is none.
  std::optional<LocalMatch> Find(const Frame& frame, const Map& map,
                                 const PoseConstraint* predicted,
                                 TrackingDiagnostics* diagnostics) const;
  // Tracks from the last frame, by the prediction; without it if that fails, or if the resulting
  // motion is implausible for a camera: the IMU may have measured an impact on the sensor.
  std::optional<LocalMatch> Follow(const Frame& frame, const Map& map,
                                   const PoseConstraint* predicted,
                                   TrackingDiagnostics* diagnostics) const;
  // Tracks from the last frame and, if the result is doubtful, from its reference keyframe.
  std::optional<LocalMatch> FollowLast(const Frame& frame, const Map& map,
                                       const PoseConstraint* predicted,
                                       TrackingDiagnostics* diagnostics) const;
  // Verifies a place that was recognized independently of the motion; empty if it may be another
  // one.
  std::optional<LocalMatch> Recognize(std::optional<TrackedFrame> rough, const Map& map,
                                      TrackingDiagnostics* diagnostics) const;
  // Matches the local map with a frame at a rough pose, with dynamic objects masked out; empty if
  // too few matches are consistent.
  std::optional<LocalMatch> TrackLocalMap(std::optional<TrackedFrame> rough, const Map& map,
                                          const PoseConstraint* predicted,
                                          FallbackConstraint fallback,
                                          TrackingDiagnostics* diagnostics) const;
  std::optional<LocalMatch> MatchLocalMap(TrackedFrame rough, const Map& map,
                                          const PoseConstraint* predicted,
                                          FallbackConstraint fallback) const;
  // Re-verifies the static pose: returns the frame at a pose from landmarks and surfaces together
  // if half or more of the dynamic mask arises only because the rough pose is slightly off.
  // Landmarks elsewhere of at least half of `support` must agree, and so must the depth of
  // keyframes. Empty if there is no such pose.
  std::optional<TrackedFrame> Reverified(TrackedFrame rough, int support, const Map& map,
                                         const PoseConstraint* predicted) const;
  // Returns whether few of the first matches are consistent with their pose.
  bool IsInconsistent(const TrackedFrame& rough) const;
  bool IsDoubtful(const LocalMatch& match) const;
  // Returns whether fewer landmarks in view are matched than in most frames.
  bool FindsLittle(const LocalMatch& match) const;
  // Returns whether the place that was recognized may be a similar one instead.
  bool LooksAlikeOnly(const LocalMatch& match, const Map& map) const;
  // Returns whether its depth is inconsistent with that of the keyframes whose landmarks it sees.
  bool Contradicts(const LocalMatch& match, const Map& map) const;
  // Returns whether its depth is inconsistent with that of these keyframes.
  bool Contradicts(const TrackedFrame& tracked, std::span<const KeyFrameId> views,
                   const Map& map) const;
  // Estimates the pose from the matches of `tracked`; unmatches outliers. False if too few remain.
  bool Solve(TrackedFrame& tracked, const Map& map, int min_support,
             const PoseConstraint* predicted, FallbackConstraint fallback) const;

  // Aligns the whole image with the reference keyframe or else the last frame; adds landmarks if
  // they are consistent.
  std::optional<LocalMatch> AlignDirectly(const Frame& frame, const Map& map,
                                          TrackingDiagnostics* diagnostics) const;
  // Returns the reference keyframe of the last frame and those that share most landmarks with it.
  std::vector<KeyFrameId> AroundReference(const Map& map, std::size_t most) const;
  // Matches the landmarks of the keyframe and its neighbours around the pose `known`.
  std::optional<LocalMatch> TrackAbout(const PoseConstraint& known, const Frame& frame,
                                       const Map& map, TrackingDiagnostics* diagnostics) const;
  // Returns rows on the planar patches of the reference keyframe of the last frame; none if it has
  // no depth.
  std::vector<PointToPlaneRow> MatchSurfaces(const TrackedFrame& tracked, const Map& map) const;

  const MeasurementModel& model_;
  const SensorModel& sensor_;
  TrackerOptions options_;
  MapMatcher matcher_;
  Relocalizer relocalizer_;
  DynamicFeatures moving_;
  DirectAligner aligner_;
  std::optional<TrackedFrame> last_;    // the last frame tracked
  int last_support_ = 0;                // support of its pose
  Stamp last_landmarks_ = 0;            // of the last frame with a pose from landmarks
  double mean_match_ratio_ = 0.0;       // mean match ratio (TrackedFrame::found); 0: unknown
  ConstantVelocity velocity_;           // at last_
  bool is_continuous_ = false;          // whether it came there by continuous motion
  bool imu_predicts_motion_ = false;    // whether an IMU predicted its motion there
  RowMotion moved_by_;                  // compensation of the features of the latest frame
  std::optional<KeyFrameId> anchored_;  // keyframe made of last_, if by images alone
};

}  // namespace highwall
