#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/options.h>
#include <highwall/frontend/pose/pose_report.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

// When the map goes on in a new submap (Map).
struct SubmapOptions {
  bool enabled = true;
  // [s] >= 0: without a pose, before the next frame that can begins a submap; a submap that did not
  // live so long is given up as fast.
  double patience = 0.3;

  void Validate() const;
};

// All that a SlamSystem may be told.
struct SlamOptions {
  FrameBuilderOptions frame{};
  MeasurementOptions measurement{};
  TrackerOptions tracker{};
  KeyFramePolicyOptions keyframes{};
  FrameRefinementOptions refinement{};
  LocalMapperOptions mapper{};
  InertialOptions inertial{};  // where there is an IMU
  LoopCloserOptions loops{};
  OwnFactorOptions factors{};  // where there are any
  DepthPatternOptions depth_pattern{};
  SubmapOptions submaps{};
  // The map that is given stays as it is, but for how often its landmarks were looked for and
  // found: frames find their pose in it, none becomes a keyframe. Images alone, without an IMU.
  bool localize_only = false;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The options with everything on the caller's thread, in lockstep: the same input then gives the
// same output, bit for bit.
SlamOptions Deterministic(SlamOptions options);

// Milliseconds of one frame. features: points and lines together, which overlap in time.
struct FrameTimes {
  double points = 0.0, lines = 0.0;
  double features = 0.0;  // both, and depth moved to the time of its pixels
  double tracking = 0.0;  // pose estimation, features not included
  double mapping = 0.0;   // local mapping, on keyframes, as far as the caller does it
  double loops = 0.0;     // applying what other threads have come to, and looking for loops
};

// What became of a frame.
struct FrameResult {
  Stamp stamp = 0;
  TrackingState state = TrackingState::kLost;
  std::optional<LossReason> reason{};  // why there is no pose, where there is none
  bool relocalized = false;
  // The colour image is the one before once more (RepeatedImage): it says nothing new, and the pose
  // is that of the motion so far.
  bool repeated = false;
  Pose T_WC;                   // causal estimate; meaningful where HasPose(state)
  SubmapId submap = kNoId;     // in whose world (Map::Root); kNoId without a pose
  bool begins_submap = false;  // the map goes on in a new one, from this frame
  bool drops_submap = false;   // the one that was left was young, and is no more (SubmapOptions)
  int points = 0, lines = 0;   // features extracted
  int matched_points = 0, matched_lines = 0;
  // Directions of the pose that these leave open, the most open one first.
  std::vector<OpenDirection> open_directions;
  // What moves, as the past tells: CV_8UC1 of the image, 255; empty where nothing does. Its
  // features make no pose and no landmarks.
  cv::Mat moving;
  std::optional<LocalMappingReport> mapping;  // where the frame became a keyframe
  std::optional<InertialReport> inertial;     // with an IMU
  // What was applied to the map since the last frame.
  std::optional<BundleAdjustmentReport> adjustment;
  std::vector<LoopReport> loops;
  std::optional<FactorAdjustmentReport> factors;  // of the user's
  FrameTimes times;
};

// What a SlamSystem tells while it works; any may be empty. Called on the thread that calls
// Track(), Finish() or AdjustAll(), before it returns and when the system is whole again: const
// members may be asked, none that changes it. What a callback throws reaches the caller.
struct SlamCallbacks {
  // A keyframe has joined the map, and the image it was made from, its depth corrected as that of
  // CorrectedDepth(): what a dense map is to be made of.
  std::function<void(const KeyFrame&, const RgbdImage&)> on_keyframe = {};
  // A loop was closed or refused, or the adjustment after one is done.
  std::function<void(const LoopReport&)> on_loop = {};
  // Tracking was lost for good, and the map goes on in a new submap, from this frame.
  std::function<void(SubmapId)> on_submap = {};
  // Two submaps are one from now on: the first report of the loop that joined them (merge), which
  // on_loop is given as well.
  std::function<void(const LoopReport&)> on_merge = {};
  // Keyframes have moved by more than a local adjustment: after a loop, an adjustment of
  // everything, to mended depth or to factors of the user's, or when gravity was found or has
  // become known much better; or a submap was dropped with its keyframes, which the map has no
  // more. Whoever keeps poses or clouds asks the map again.
  std::function<void(const Map&)> on_map = {};
  // Every frame, lost ones included, after the above: what Track() returns.
  std::function<void(const FrameResult&)> on_frame = {};
};

// What became of the factors of the user's.
struct FactorCounts {
  std::size_t waiting = 0;   // for a frame at their stamp
  std::size_t attached = 0;  // to keyframes
  std::size_t refused = 0;   // there was no frame with a pose near enough
};

// What was tracked in one world frame.
struct SubmapTrajectory {
  SubmapId submap = kNoId;    // root of those that are joined
  std::size_t keyframes = 0;  // live
  Trajectory frames;          // T_WC, as SlamSystem::trajectory()
};

// [s] No camera pauses for longer between two frames: a stamp that jumps farther is a fault of the
// clock, unless the next frame follows it (SlamSystem::Track).
inline constexpr double kLongestPause = 86'400.0;

// Point-line RGB-D(-inertial) odometry with a map: images and the readings of an IMU in, poses and
// keyframes out. Local adjustments and loops are computed on threads of their own and applied
// between frames (SlamOptions::mapper, loops; Deterministic()).
//
// World W: origin at the first camera, x along its optical axis, z up where the camera was held
// level; with an IMU z is up in any case, and the whole map turns a little when it has found where
// up is. A frame that cannot be tracked is bridged by the IMU, else reported as lost and without a
// pose; the map stays, and later frames are relocalized in it. Where that fails for a moment
// (SubmapOptions), the map goes on in a new submap with a world of its own; when that meets an
// older one, the two are joined as a loop is closed.
class SlamSystem {
 public:
  // Throws InvalidArgument on bad options.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options = {});
  // imu: with one every reading until some 50 ms after an image goes to AddImu() before that image.
  // map: of the same camera, to go on in (LoadMap): lost until a frame is recognized. Throws
  // InvalidArgument also where localize_only comes with an IMU or without a map.
  // points: a PointExtractor of your own (docs/own_features.md), in the place of what
  // FrameBuilderOptions::point_detector says; a map that is given has points of the same
  // PointKind::name, in the same pyramid.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options,
             const std::optional<ImuCalibration>& imu, Map map = {},
             std::shared_ptr<PointExtractor> points = nullptr);
  // Work on other threads that has not ended is given up.
  ~SlamSystem();
  SlamSystem(SlamSystem&&) noexcept;
  SlamSystem& operator=(SlamSystem&&) noexcept;

  // For the calls that follow.
  void SetCallbacks(SlamCallbacks callbacks);

  // Readings may come late or twice; what became of one is returned, and Advice() says what to do
  // where it was refused (ImuBuffer::Add): the others go on. Throws InvalidArgument where
  // the system was made without an IMU.
  ImuSampleStatus AddImu(const ImuSample& sample);

  // A frame that factors of your own are measured in.
  ReferenceFrameId AddReferenceFrame(const ReferenceFrame& frame = {});
  // A measurement of your own (docs/own_factors.md), in any order, before or after the frames of
  // its stamps. Takes part in local adjustments, loops and AdjustAll(), and moves the whole map
  // where it has drifted. Throws InvalidArgument where it is not as PoseFactor says, its frame is
  // none of this system, or the system localizes only.
  void AddFactor(PoseFactor factor);
  // T_FW, where F lies, in the world of trajectory(); empty as long as that is not known.
  std::optional<Pose> T_FW(ReferenceFrameId frame) const;
  FactorCounts factor_counts() const;

  // Throws InvalidArgument where stamps do not ascend, images do not fit, or depth is not in
  // metres; a frame that was refused leaves no trace. So does a stamp more than kLongestPause after
  // the frame before: once, so that one wrong stamp does not end the use of those that follow, and
  // the next frame is taken where it is the same once more, or follows it.
  FrameResult Track(const RgbdImage& image);

  // What moves in the image of a live keyframe (FrameResult::moving), by what was seen in the
  // seconds before and since: a second or two later more is known than at once.
  cv::Mat MovingIn(KeyFrameId keyframe) const;
  // The depth [m] of a live keyframe's image, corrected by what is known by now, as the keyframe's
  // features are: without depth_pattern(), and each reading at the time of its pixel
  // (docs/row_times.md). depth: CV_32FC1, as it was given to Track(), else throws InvalidArgument.
  // Of a keyframe that is not of this run the pattern alone is taken off.
  cv::Mat CorrectedDepth(KeyFrameId keyframe, const cv::Mat& depth) const;

  // Waits for what is being adjusted and for the loop that is being closed, if any, applies both to
  // the map, and then what factors of the user's are new; finds the poses of the last frames once
  // more.
  std::vector<LoopReport> Finish();
  // After Finish(): one more adjustment of all keyframes and landmarks together. Frames follow.
  // Throws InvalidArgument where the system localizes only.
  BundleAdjustmentReport AdjustAll();

  // T_WC of every tracked frame after all adjustments so far: a frame keeps its pose relative to
  // the keyframe it was tracked against, or was found against once more (SlamOptions::refinement;
  // the last of them by Finish()). Of the first of submaps(); empty where there is none.
  Trajectory trajectory() const;
  // T_WC of the live keyframes of this run, without those of a map that was given, in that world.
  Trajectory keyframe_trajectory() const;
  // Each world in which frames were tracked and is still one: that of most frames first.
  std::vector<SubmapTrajectory> submaps() const;

  // When the rows of the images are taken, as found out so far (TrackerOptions::timing).
  FrameTimingEstimate timing() const;
  // By how much the depth of the images that were given is off over the image, as found out so far
  // and mended (SlamOptions::depth_pattern): what RgbdSensor::depth_pattern lacks.
  DepthPattern depth_pattern() const;
  // How many frames had their pose found once more (SlamOptions::refinement).
  int refined_frames() const;
  // How noisy observations are, as found out so far (TrackerOptions::learn_noise).
  NoiseEstimate noise() const;

  const Map& map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
