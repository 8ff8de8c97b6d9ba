#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/frontend/input/repeated_image.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/system/slam_system.h>

#include "features/frame_builder.h"
#include "inertial/inertial_odometry.h"
#include "local/local_mapper.h"
#include "loops/depth_pattern_finder.h"
#include "loops/factor_adjuster.h"
#include "loops/loop_closer.h"
#include "system/pending_factors.h"
#include "tracking/frame_refiner.h"
#include "tracking/keyframe_policy.h"
#include "tracking/tracker.h"

namespace highwall {

// What SlamSystem does, one stage after the other; its public functions have their docs there.
class SlamSystem::Impl {
 public:
  Impl(const RgbdSensor& sensor, const SlamOptions& options,
       const std::optional<ImuCalibration>& imu, Map map, std::shared_ptr<PointExtractor> points);

  void SetCallbacks(SlamCallbacks callbacks) { callbacks_ = std::move(callbacks); }
  ImuSampleStatus AddImu(const ImuSample& sample);
  ReferenceFrameId AddReferenceFrame(const ReferenceFrame& frame) {
    return map_.factors().AddFrame(frame);
  }
  void AddFactor(PoseFactor factor);
  std::optional<Pose> T_FW(ReferenceFrameId frame) const;
  FactorCounts factor_counts() const {
    return {pending_.waiting(), pending_.attached(), pending_.refused()};
  }
  FrameResult Track(const RgbdImage& image);
  cv::Mat MovingIn(KeyFrameId keyframe) const;
  cv::Mat CorrectedDepth(KeyFrameId keyframe, const cv::Mat& depth) const;
  std::vector<LoopReport> Finish();
  BundleAdjustmentReport AdjustAll();
  Trajectory trajectory() const;
  Trajectory keyframe_trajectory() const;
  std::vector<SubmapTrajectory> submaps() const;
  NoiseEstimate noise() const { return tracker_.noise(); }
  FrameTimingEstimate timing() const { return tracker_.timing_estimate(); }
  const DepthPattern& depth_pattern() const { return depth_pattern_.pattern(); }
  int refined_frames() const { return refiner_.refined(); }
  const Map& map() const { return map_; }

 private:
  // Throws InvalidArgument where the stamp cannot be that of the next frame.
  void RequireNext(Stamp stamp);
  // A submap that is lost with fewer, and joined with no other, is dropped: it began in blur.
  static constexpr int kMinSubmapKeyFrames = 5;

  // The stages of Track(), in their order.
  // Makes the depth of an image that of its own rows' times, as the camera is expected to move,
  // and takes its pattern off. Nothing where it is so.
  FrameBuilder::DepthChange ToOneTime(const RgbdImage& image) const;
  Frame Extract(RgbdImage* image, FrameResult& result);
  // Whether the image shows nothing new.
  bool Repeats(const RgbdImage& image);
  // The pose of a frame that shows nothing new: that of the motion so far.
  TrackedFrame GoOn(const Frame& frame, FrameResult& result);
  // The pose: by the images, and with the IMU where there is one. Starts a map where there is none.
  TrackedFrame Estimate(const Frame& frame, FrameResult& result);
  // In which submap the frame was tracked; one that it has left young is dropped.
  void ChooseSubmap(TrackedFrame& tracked, FrameResult& result);
  // Whether a frame without a pose may begin a submap: the first that can, after some patience.
  bool CanBegin(const TrackedFrame& tracked) const;
  void BeginSubmap(TrackedFrame& tracked, FrameResult& result);
  // Drops the submap if it is not worth keeping, now that it is left.
  void LeaveSubmap(FrameResult& result);
  void Report(const TrackedFrame& tracked, FrameResult& result);
  // Applies what was found of the poses of earlier frames, and looks for more.
  void RefineFrames(FrameResult& result);
  ImageKnowledge Knowledge() const;

  // Cells that move as pixels, their border included; empty where there are none.
  cv::Mat ToImage(const cv::Mat& moving) const;
  Pose FirstPose(Stamp stamp) const;
  void FollowSharpness(const FrameFeatures& features);
  // What an image tells the IMU.
  InertialOdometry::Observation Observe(const TrackedFrame& tracked);
  // Fuses the frame with the IMU.
  void Fuse(InertialOdometry::Observation observation, TrackedFrame& tracked, FrameResult& result);
  LossReason ReasonOf(const TrackedFrame& lost) const;
  bool WantsKeyFrame(const TrackedFrame& tracked) const;
  void InsertKeyFrame(TrackedFrame& tracked, FrameResult& result);
  void LookForLoop(TrackedFrame& tracked, FrameResult& result);
  // Applies what was found out of the pattern of depth, between frames; whether the map was moved.
  bool MendDepth(FrameResult& result);
  // Applies what has come of the factors of the user's, and begins anew where enough are new.
  void AdjustToFactors(TrackedFrame& tracked, FrameResult& result);
  std::optional<KeyFrameMotion> MotionSince(const KeyFrame* last) const;
  // Changes the map and lets tracker and odometry follow: by how the reference keyframe moved.
  template <class Change>
  Pose WithTracker(const Change& change);
  // Applies what the other threads have come to.
  void ApplyResults(FrameResult& result);
  void Notify(const FrameResult& result, const RgbdImage& image) const;
  void Notify(const std::vector<LoopReport>& loops) const;
  // The root of the world in which most frames were tracked; empty where there is none.
  std::optional<SubmapId> LargestWorld() const;

  SlamOptions options_;
  FrameBuilder builder_;
  MeasurementModel model_;
  Tracker tracker_;
  KeyFramePolicy policy_;
  FrameRefiner refiner_;
  LocalMapper mapper_;
  std::optional<InertialOdometry> inertial_;
  LoopCloser loop_closer_;
  FactorAdjuster factor_adjuster_;
  DepthPatternFinder depth_pattern_;
  PendingFactors pending_;
  Map map_;
  SlamCallbacks callbacks_;
  std::vector<PosedFrame> tracked_;
  std::map<SubmapId, std::size_t> frames_in_;  // how many of these, by the submap of their keyframe
  std::optional<Stamp> last_stamp_;
  std::optional<Stamp> jumped_;  // the stamp that was refused last because it jumped
  bool metric_ = false;          // depth was seen to be in metres
  RepeatedImage repeated_;
  std::optional<LossReason> lost_for_;  // of the last frame, where it has no pose
  SubmapId submap_ = kFirstSubmap;      // that keyframes join now
  Stamp submap_begin_ = 0;              // the stamp of its first frame
  int submap_keyframes_ = 0;            // made in it
  std::optional<Stamp> posed_;          // the last frame with a pose; until there is one, the first
  KeyFrameId last_given_keyframe_;      // those up to it came with the map
  std::int64_t next_index_ = 0;
  Stamp last_keyframe_stamp_ = 0;
  KeyFrameId last_keyframe_ = kNoId;
  Stamp last_visual_ = 0;  // of the last frame whose image told its pose
  int last_points_ = 0;    // matched in the last frame
  double usual_sharpness_ = 0.0;
  double tied_ = 0.0;     // [s] that the IMU ties since the last keyframe
  double weighed_ = 0.0;  // the same, each interval times its weight
  Stamp last_fused_ = 0;
};

}  // namespace highwall
