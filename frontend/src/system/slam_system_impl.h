#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/frontend/inertial/inertial_odometry.h>
#include <highwall/frontend/input/repeated_image.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/system/slam_system.h>

#include "calibration/depth_distortion_estimator.h"
#include "calibration/lens_check.h"
#include "features/frame_builder.h"
#include "local/local_mapper.h"
#include "loops/factor_adjuster.h"
#include "loops/loop_closer.h"
#include "sensor/colour_delay.h"
#include "sensor/sensor_model.h"
#include "system/backlog.h"
#include "system/frame_clock.h"
#include "system/frame_trajectories.h"
#include "system/keyframe_release.h"
#include "system/map_worker.h"
#include "system/pending_factors.h"
#include "system/stamp_sequence.h"
#include "system/uncertainty_estimator.h"
#include "tracking/frame_refiner.h"
#include "tracking/lost_frames.h"
#include "tracking/tracker.h"

namespace highwall {

// Returns whether any of the loops moved keyframes.
bool MoveKeyframes(const std::vector<LoopReport>& loops);

// Implementation of SlamSystem, one stage after the other; its public functions are documented
// there.
class SlamSystem::Impl {
 public:
  Impl(const RgbdSensor& sensor, const SlamOptions& options, SlamInputs inputs);

  void SetCallbacks(SlamCallbacks callbacks) { callbacks_ = std::move(callbacks); }
  ImuSampleStatus AddImu(const ImuSample& sample);
  ReferenceFrameId AddReferenceFrame(const ReferenceFrame& frame) {
    return map_.factors().AddFrame(frame);
  }
  void AddFactor(PoseFactor factor);
  std::optional<Pose> T_FW(ReferenceFrameId frame) const;
  FactorCounts factor_counts() const { return pending_.Counts(map_.factors()); }
  std::map<std::string, FactorCounts> factor_counts_by_source() const {
    return pending_.BySource(map_.factors());
  }
  void SetBacklog(std::size_t images) { backlog_.Set(images); }
  const PostponedWork& postponed() const { return backlog_.postponed(); }
  FrameResult Track(const RgbdImage& image);
  cv::Mat DynamicMaskOf(KeyFrameId keyframe) const;
  cv::Mat CorrectedDepth(KeyFrameId keyframe, const cv::Mat& depth) const;
  std::optional<KeyframeView> keyframe_view(KeyFrameId keyframe, const RgbdImage& image) const;
  KeyframeEvent waiting_keyframes() const;
  std::vector<LoopReport> Finish();
  BundleAdjustmentReport AdjustAll();
  Trajectory trajectory() const;
  std::vector<FrameVelocity> velocities() const;
  Trajectory keyframe_trajectory() const;
  std::vector<SubmapTrajectory> submaps() const { return tracked_.ByWorld(map_); }
  SensorEstimate sensor() const {
    return {sensor_.timing_estimate(), depth_pattern_.pattern(), sensor_.noise()};
  }
  const SensorVerdict& verdict() const { return verdict_; }
  int refined_frames() const { return refiner_.refined(); }
  std::vector<MemoryShare> memory() const;
  const Map& map() const { return map_; }

 private:
  // A submap with fewer keyframes that is lost before it is merged is dropped: it began in blur.
  static constexpr int kMinSubmapKeyFrames = 5;

  // The stages of Track(), in their order.
  // Returns the change of the depth of the image with this stamp: where its colour is late, the
  // depth that was taken with the colour replaces it; then it is compensated for rolling shutter by
  // the expected motion, and its distortion is corrected.
  FrameBuilder::DepthChange DepthChangeOf(Stamp stamp);
  Frame Extract(RgbdImage* image, FrameResult& result);
  // Returns whether the image repeats the previous one.
  bool Repeats(const RgbdImage& image);
  // Returns the pose of a frame with a repeated image, extrapolated by the motion so far.
  TrackedFrame Extrapolate(const Frame& frame, FrameResult& result);
  // Estimates the pose from the images and the IMU, if there is one. Starts a map if there is none.
  TrackedFrame Estimate(const Frame& frame, FrameResult& result);
  // Tracks the frame; counts its landmarks in the map, and learns the sensor from it.
  TrackedFrame TrackInMap(const Frame& frame, const std::optional<PoseConstraint>& predicted);
  // Sets the submap that the frame was tracked in; drops the one it has left if that is too young.
  void ChooseSubmap(TrackedFrame& tracked, FrameResult& result);
  // Returns whether a frame without a pose may begin a submap: the first suitable one after the
  // lost timeout.
  bool CanBegin(const TrackedFrame& tracked) const;
  void BeginSubmap(TrackedFrame& tracked, FrameResult& result);
  // Drops the submap that is being left if it is too young to be kept.
  void LeaveSubmap(FrameResult& result);
  void Report(const TrackedFrame& tracked, const std::optional<ImageInformation>& information,
              FrameResult& result);
  // Returns what the image of a frame that was just tracked states about its pose
  // (PosedFrame::information).
  std::optional<ImageInformation> InformationOf(const TrackedFrame& tracked) const;
  // Returns how uncertain the pose of a frame that was just tracked is; empty without a pose.
  std::optional<PoseUncertainty> UncertaintyOf(const TrackedFrame& tracked,
                                               const FrameResult& result);
  // Keeps a frame without a pose, to be searched for at the end.
  void RememberLost(const TrackedFrame& tracked, Stamp stamp);
  // The same for the frames of the submap that is about to be dropped.
  void RememberDropped();
  // Applies refined poses of earlier frames and starts the refinement of more.
  void RefineFrames(FrameResult& result);
  // Refines those that wait, searches for the lost ones, and smooths the trajectory.
  void FinishFrames();
  ImageKnowledge Knowledge() const;

  // Returns the dynamic mask in pixels, with its border; empty if there is none.
  cv::Mat ToImage(const cv::Mat& moving) const;
  Pose FirstPose(Stamp stamp) const;
  void FollowSharpness(const FrameFeatures& features);
  // Returns the observation of an image for the IMU fusion.
  InertialOdometry::Observation Observe(const TrackedFrame& tracked);
  // Fuses the frame with the IMU.
  void Fuse(InertialOdometry::Observation observation, TrackedFrame& tracked, FrameResult& result);
  // Removes all that a contradicted IMU has left in the world of this run: IMU factors, gravity,
  // motions of rows, what they did to the keyframes, by an adjustment, and to the latest frames,
  // which get the poses from their images. Returns the motion of the tracker's reference.
  Pose ForgetImu();
  // Returns the readings of the IMU from the frame before to the newest one; null if they are not
  // all there.
  std::shared_ptr<const ReadingsBetween> ReadingsFromBefore();
  // Returns the readings between the stamps of two images, with the present bias of a running IMU;
  // null likewise.
  std::shared_ptr<const ReadingsBetween> Readings(Stamp from, Stamp to) const;
  // Gives the frames of this world until now, tracked before the IMU was initialized, the readings
  // between them, so that these smooth the whole trajectory.
  void AddReadingsBeforeStart();
  // Corrects the motions by which the rows of the keyframes of this world were compensated, tracked
  // at constant velocity before the IMU was initialized, by the readings after each of them.
  void CorrectMotionsBeforeStart();
  LossReason ReasonOf(const TrackedFrame& lost) const;
  bool WantsKeyFrame(const TrackedFrame& tracked);
  // Returns whether a keyframe that is due waits until the running adjustment ends.
  bool Postpones(const TrackedFrame& tracked, double since_keyframe);
  void InsertKeyFrame(TrackedFrame& tracked, FrameResult& result);
  // Does one of the things that are due, so that no frame waits for all that follows on a keyframe.
  void DoWhatIsDue(FrameResult& result);
  // Searches for a loop of the newest keyframe.
  void LookForLoop(FrameResult& result);
  // At the end: closes a loop and merges submaps by the newest keyframes, which no more will
  // confirm.
  std::vector<LoopReport> CloseLastLoop();
  // Applies an estimated depth distortion, between frames; returns whether the map was changed.
  bool CorrectDepth(FrameResult& result);
  // Applies the result of the adjustment to user factors, and begins anew if enough are new.
  void AdjustToFactors(TrackedFrame& tracked, FrameResult& result);
  std::optional<InertialState> MotionSince(const KeyFrame* last) const;
  // Changes the map and transforms tracker and odometry by the motion of the reference keyframe.
  template <class Change>
  Pose WithTracker(const Change& change);
  // Edits a world by the result of a stage, after the local adjustment in progress is complete.
  template <class Change>
  void EditWorld(FrameResult& result, const Change& change);
  // Applies the results of local adjustments and loops.
  void ApplyResults(FrameResult& result);
  // image: with corrected depth. moved: keyframes have moved, for another reason than the result's.
  void Notify(const FrameResult& result, const RgbdImage& image, bool moved);
  void Notify(const std::vector<LoopReport>& loops) const;
  void NotifyMoved() const;
  // Tests the lens by the map if that has grown by enough, or at the end.
  void CheckLens(bool at_end);
  // Adds a finding to the verdict; the next Notify() reports it.
  void Find(SensorFinding finding);
  void NotifyFindings();
  // Collects the changes of the keyframes by this frame for on_keyframes.
  void Collect(const FrameResult& result, const RgbdImage& image, bool moved);
  void EmitKeyframes(Stamp now);
  void EmitAllKeyframes();
  KeyframeRelease::MaskOf DynamicMasks() const;

  SlamOptions options_;
  RunProfile* profile_;
  FrameBuilder builder_;
  MeasurementModel model_;
  SensorModel sensor_;
  Tracker tracker_;
  std::shared_ptr<KeyFramePolicy> policy_;
  FrameRefiner refiner_;
  LostFrames lost_frames_;
  LocalMapper mapper_;
  std::optional<InertialOdometry> inertial_;
  LoopCloser loop_closer_;
  FactorAdjuster factor_adjuster_;
  DepthDistortionEstimator depth_pattern_;
  LensCheck lens_check_;
  struct {
    bool loop_search = false, lens_check = false;
  } due_;  // after a keyframe, before one of the next frames is tracked
  MapWorker worker_;
  PendingFactors pending_;
  Map map_;
  SlamCallbacks callbacks_;
  KeyframeRelease release_;
  SensorVerdict verdict_;
  std::vector<SensorFinding> new_findings_;  // not reported by on_finding yet
  FrameTrajectories tracked_;
  UncertaintyEstimator uncertainty_;
  StampSequence stamps_;
  FrameClock clock_;
  bool metric_ = false;  // depth was verified to be in metres
  RepeatedImage repeated_;
  ColourDelay colour_delay_;
  std::optional<LossReason> lost_for_;  // of the last frame, if it has no pose
  SubmapId submap_ = kFirstSubmap;      // that keyframes currently join
  Stamp submap_begin_ = 0;              // stamp of its first frame
  int submap_keyframes_ = 0;            // made in it
  std::optional<Stamp> posed_;          // the last frame with a pose; until there is one, the first
  KeyFrameId last_given_keyframe_;      // keyframes up to it came with the given map
  KeyFrameId searched_at_end_ = kNoId;  // the newest keyframe at the last CloseLastLoop()
  Backlog backlog_;
  std::int64_t next_index_ = 0;
  Stamp last_keyframe_stamp_ = 0;
  KeyFrameId last_keyframe_ = kNoId;
  Stamp last_visual_ = 0;  // of the last frame with a pose from its image
  int last_points_ = 0;    // matched in the last frame
  double usual_sharpness_ = 0.0;
  double imu_constrained_time_ = 0.0;  // [s] covered by IMU factors since the last keyframe
  double weighed_ = 0.0;               // the same, each interval times its weight
  Stamp last_fused_ = 0;
  std::optional<AnchoredPose> image_pose_;  // of the newest frame, if `pose` is fused with the IMU
  std::optional<Stamp> fused_before_;       // of the last frame with a pose
};

template <class Change>
Pose SlamSystem::Impl::WithTracker(const Change& change) {
  const KeyFrameId reference = tracker_.reference().value_or(last_keyframe_);
  if (reference == kNoId) {  // no map yet
    change();
    return {};
  }
  const Pose before = map_.ResolvePose(reference);
  change();
  const Pose T_new_old = map_.ResolvePose(reference) * before.Inverse();
  tracker_.Transform(T_new_old);
  if (inertial_) inertial_->MoveMap(T_new_old);
  return T_new_old;
}

}  // namespace highwall
