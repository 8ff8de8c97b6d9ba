#pragma once

#include <optional>
#include <span>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "map/map_matcher.h"
#include "pose/degeneracy.h"
#include "pose/direct_alignment.h"
#include "pose/pose_solver.h"
#include "pose/surface_matcher.h"
#include "tracking/constant_velocity.h"
#include "tracking/frame_timing_estimator.h"
#include "tracking/moving_features.h"
#include "tracking/noise_estimator.h"
#include "tracking/relocalizer.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Camera pose frame by frame: prediction by an IMU or at constant velocity, matching of the last
// frame's landmarks by projection, pose by SolvePose, then the same with the landmarks of the local
// map. Falls back on descriptor matching with the reference keyframe, then on relocalization. (Xiao
// et al. 2025, figure 2, tracking.)
class Tracker {
 public:
  // model: must outlive the tracker. timing: as far as it is known.
  Tracker(const MeasurementModel& model, const TrackerOptions& options,
          const FrameTiming& timing = {});
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  // The features of `frame` are as its rows saw them, those of what is returned as its middle row
  // would have. predicted: the pose that an IMU tells, where there is one. Also counts in the map
  // how often landmarks were in view and found.
  TrackedFrame Track(const Frame& frame, Map& map,
                     const std::optional<KnownPose>& predicted = std::nullopt);

  // Tells the tracker that `tracked` became the keyframe: its landmarks, new ones included, are
  // the ones the next frame is matched to, from its pose after the adjustment.
  void Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe);
  // Where the camera is thought to be at constant velocity since the last frame; empty when lost,
  // or after so long that nobody knows. The last frame stays the last.
  std::optional<TrackedFrame> Coast(const Frame& frame) const;
  // The frames so far are of another world than those that follow.
  void Forget() { last_.reset(); }
  // The pose of the last frame as it was found in the end.
  void Correct(const Pose& T_WC);
  // The keyframe that the last tracked frame shares most landmarks with; empty when lost.
  std::optional<KeyFrameId> reference() const;
  // The cells of a keyframe that move, as the depth of the seconds before and since tells.
  cv::Mat MovingIn(const KeyFrame& keyframe, const Map& map) const;
  // The motion expected at the next frame: that of `predicted`, or the last; none where the camera
  // was lost.
  Twist Motion(const KnownPose* predicted) const;
  // When the rows of images are taken, as far as that is known by now.
  const FrameTiming& timing() const { return timing_.timing(); }
  FrameTimingEstimate timing_estimate() const { return timing_.estimate(); }
  // What the features of the frame seen last were moved by.
  const RowMotion& moved_by() const { return moved_by_; }
  // How noisy the rows of observations are, as far as that is known by now.
  const NoiseEstimate& noise() const { return noise_.estimate(); }
  // Learns it from keyframes, as an adjustment has left them.
  void LearnNoise(const Map& map, std::span<const KeyFrameId> keyframes);
  // Keyframes and their landmarks follow where their rows' times are known better by now; their
  // poses are left to the adjustment that follows. Those that share most landmarks with a frame, at
  // most `most`, or all.
  void RetimeAround(const TrackedFrame& tracked, int most, Map* map);
  void RetimeAll(Map* map);
  // What the rows of a keyframe were moved by; null where it is not of this run.
  const RowMotion* RowsOf(KeyFrameId keyframe) const { return keyframe_times_.Find(keyframe); }
  // Follows the map, which has moved about here: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);

 private:
  void Retime(std::span<const KeyFrameId> keyframes, Map* map);
  // What may tell a pose, beside points and lines.
  enum class Aid { kNone, kSurfaces };

  bool LearnsNoise() const;
  // Of the images of one frame; nothing where all is of one time.
  std::optional<FrameTiming> TimingOf(const Frame& frame) const;
  // Whether the camera may have come here by moving on; else twists tell nothing.
  bool GoesOn(const Twist& expected, const TrackedFrame& tracked) const;
  // A frame that was found from the last one. predicted: unless images denied it.
  void GoOn(const KnownPose* predicted, bool has_landmarks, Map& map, TrackedFrame* tracked);
  // Features that were moved by an expected motion, moved by the one that was found, and the pose
  // from them.
  void FollowMotion(const Map& map, const KnownPose* predicted, TrackedFrame* tracked);
  // [px] by which the image shifts until `frame` at constant velocity.
  double Shift(const Frame& frame) const;
  // [s] from the last frame tracked to `frame`.
  double SinceLast(const Frame& frame) const;
  std::optional<TrackedFrame> TrackMotion(const Frame& frame, const Map& map,
                                          const KnownPose* predicted, Aid aid,
                                          LossClues* clues) const;
  std::optional<TrackedFrame> TrackReference(const Frame& frame, const Map& map) const;
  std::optional<TrackedFrame> Relocalize(const Frame& frame, const Map& map) const;
  // A frame matched with the local map, and the landmarks that were to be seen from its pose.
  struct LocalMatch {
    TrackedFrame frame;
    std::vector<PointId> points_in_view;
    std::vector<LineId> lines_in_view;
    bool prediction_denied = false;  // found where the prediction is not

    int Support() const;
    void CountObservations(Map& map) const;
  };
  // The pose of a frame: from the last one, recognized, or held by surfaces or
  // by all of the image. clues: of what failed.
  std::optional<LocalMatch> Find(const Frame& frame, const Map& map, const KnownPose* predicted,
                                 LossClues* clues) const;
  // From the last frame, by the prediction; without it where that finds nothing, or where the
  // camera would have come as no camera does: readings may be those of a blow to the sensor.
  std::optional<LocalMatch> Follow(const Frame& frame, const Map& map, const KnownPose* predicted,
                                   LossClues* clues) const;
  // From the last frame and, where that is in doubt, its reference keyframe.
  std::optional<LocalMatch> FollowLast(const Frame& frame, const Map& map,
                                       const KnownPose* predicted, LossClues* clues) const;
  // Of a place that was recognized whatever the motion says; empty where it may be another one.
  std::optional<LocalMatch> Recognize(std::optional<TrackedFrame> rough, const Map& map,
                                      LossClues* clues) const;
  // Adds what the local map holds to a frame with a rough pose, what moves set aside; empty where
  // too little fits.
  std::optional<LocalMatch> TrackLocalMap(std::optional<TrackedFrame> rough, const Map& map,
                                          const KnownPose* predicted, Aid aid,
                                          LossClues* clues) const;
  std::optional<LocalMatch> MatchLocalMap(TrackedFrame rough, const Map& map,
                                          const KnownPose* predicted, Aid aid) const;
  // The frame at a pose that landmarks and surfaces give together, where half or more of what seems
  // to move only does so because the rough pose is a little off. Of the landmarks elsewhere half of
  // `support` at least must agree, and the depth of keyframes. Empty where there is no such pose.
  std::optional<TrackedFrame> Steadied(TrackedFrame rough, int support, const Map& map,
                                       const KnownPose* predicted) const;
  // Few of the first matches agree with their pose.
  bool IsDenied(const TrackedFrame& rough) const;
  bool IsDoubtful(const LocalMatch& match) const;
  // Less of what is in view than frames usually find.
  bool FindsLittle(const LocalMatch& match) const;
  // May the place that was recognized be another one that looks alike?
  bool LooksAlikeOnly(const LocalMatch& match, const Map& map) const;
  // Does its depth contradict that of the keyframes whose landmarks it sees?
  bool Contradicts(const LocalMatch& match, const Map& map) const;
  // Does its depth contradict that of these keyframes?
  bool Contradicts(const TrackedFrame& tracked, std::span<const KeyFrameId> views,
                   const Map& map) const;
  // Pose from the matches of `tracked`; outliers are unmatched. False where too few remain.
  bool Solve(TrackedFrame& tracked, const Map& map, int min_support, const KnownPose* predicted,
             Aid aid) const;

  // From all of the image, against the reference keyframe or else the last frame; with landmarks
  // where they agree.
  std::optional<LocalMatch> AlignDirectly(const Frame& frame, const Map& map,
                                          LossClues* clues) const;
  // The reference keyframe of the last frame and those that share most with it.
  std::vector<KeyFrameId> AroundReference(const Map& map, std::size_t most) const;
  // The landmarks that the keyframe and its neighbours see, as far as they are found about `known`.
  std::optional<LocalMatch> TrackAbout(const KnownPose& known, const Frame& frame, const Map& map,
                                       LossClues* clues) const;
  // Rows on the flat patches that the reference keyframe of the last frame saw; none where it has
  // no depth.
  std::vector<PointToPlaneRow> MatchSurfaces(const TrackedFrame& tracked, const Map& map) const;

  const MeasurementModel& model_;
  TrackerOptions options_;
  MapMatcher matcher_;
  Relocalizer relocalizer_;
  MovingFeatures moving_;
  KeyframeRowTimes keyframe_times_;
  FrameTimingEstimator timing_;
  NoiseEstimator noise_;
  DirectAligner aligner_;
  std::optional<TrackedFrame> last_;    // the last frame tracked
  int last_support_ = 0;                // of its pose
  Stamp last_landmarks_ = 0;            // of the last frame that landmarks held
  double usual_found_ = 0.0;            // TrackedFrame::found of late; 0: not known
  ConstantVelocity velocity_;           // at it
  bool goes_on_ = false;                // whether it came there by moving on
  bool told_ = false;                   // whether an IMU told its motion there
  RowMotion moved_by_;                  // what the features of the frame seen last were moved by
  std::optional<KeyFrameId> anchored_;  // the keyframe that it became, where images alone tell it
};

}  // namespace highwall
