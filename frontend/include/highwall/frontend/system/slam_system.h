#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/keyframe_event.h>
#include <highwall/core/memory_share.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/calibration/options.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/options.h>
#include <highwall/frontend/pose/pose_report.h>
#include <highwall/frontend/pose/pose_uncertainty.h>
#include <highwall/frontend/sensor/sensor_estimate.h>
#include <highwall/frontend/tracking/keyframe_policy.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

class RunProfile;

// Options of submaps: when the map continues in a new submap (Map).
struct SubmapOptions {
  bool enabled = true;
  // [s] >= 0: lost timeout without a pose, after which the next suitable frame begins a submap; for
  // a young submap the timeout is at most its own age.
  double lost_timeout = 0.3;

  void Validate() const;
};

// Options of SlamSystem.
struct SlamOptions {
  FrameBuilderOptions frame{};
  MeasurementOptions measurement{};
  TrackerOptions tracker{};
  KeyFramePolicyOptions keyframes{};
  FrameRefinementOptions refinement{};
  LocalMapperOptions mapper{};
  InertialOptions inertial{};  // with an IMU
  LoopCloserOptions loops{};
  UserFactorOptions factors{};  // with user factors
  DepthPatternOptions depth_pattern{};
  SubmapOptions submaps{};
  // The given map is not changed, except for how often its landmarks were predicted and matched:
  // frames are localized in it, none becomes a keyframe. Images only, without an IMU.
  bool localize_only = false;
  // [0, 256]: local adjustments, loops, the tightly coupled smoother and the other stages that do
  // not hold up a frame each run on a thread of their own, and solvers of a whole map on this many.
  // 0: synchronous, all on the caller's thread; the same input then gives the same output.
  int threads = 2;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns the options in synchronous mode, with everything on the caller's thread: the same input
// then gives the same output, bit for bit.
SlamOptions Deterministic(SlamOptions options);

// Milliseconds of one frame. features: points and lines together, which overlap in time.
struct FrameTimes {
  double points = 0.0, lines = 0.0;
  double features = 0.0;  // both, and the rolling-shutter compensation of depth
  double tracking = 0.0;  // pose estimation, features not included
  double mapping = 0.0;   // local mapping of keyframes, the part on the caller's thread
  double loops = 0.0;     // applying results of other threads, and searching for loops
  // Wall time of Track() up to on_frame: all of the above, keyframes, waits for other threads, and
  // the other callbacks.
  double total = 0.0;
};

// Result of tracking one frame.
struct FrameResult {
  Stamp stamp = 0;
  TrackingState state = TrackingState::kLost;
  std::optional<LossReason> reason{};  // set if there is no pose
  bool relocalized = false;
  // The colour image repeats the previous one (RepeatedImage): it gives no new constraint, and the
  // pose is predicted by the IMU, or by the motion of the last seconds without one.
  bool repeated = false;
  // [ns] by which its colour was taken before the stamp, found where images repeat; a keyframe made
  // of it has the stamp of its colour
  Stamp colour_delay = 0;
  Pose T_WC;                                     // causal estimate; meaningful where HasPose(state)
  std::optional<PoseUncertainty> uncertainty{};  // of it; set where HasPose(state)
  SubmapId submap = kNoId;     // of the world of the pose (Map::Root); kNoId without a pose
  bool begins_submap = false;  // the map continues in a new submap from this frame
  // the submap that was left was too young and was removed (SubmapOptions)
  bool drops_submap = false;
  int points = 0, lines = 0;  // features extracted
  int matched_points = 0, matched_lines = 0;
  // The features without those on dynamic objects, and which of them are matched with the map; null
  // and empty if the image repeats the previous one.
  std::shared_ptr<const FrameFeatures> features{};
  FeatureFlags matched{};
  // Directions of the pose that are unobservable (degenerate), the worst first.
  std::vector<UnobservableDirection> unobservable_directions;
  // Dynamic mask from the past frames: CV_8UC1 of the image, 255; empty if nothing moves. Features
  // in it constrain no pose and create no landmarks.
  cv::Mat moving;
  std::optional<LocalMappingReport> mapping;  // if the frame became a keyframe
  std::optional<InertialReport> inertial;     // with an IMU
  // Applied to the map since the last frame.
  std::optional<BundleAdjustmentReport> adjustment;
  std::vector<LoopReport> loops;
  std::optional<FactorAdjustmentReport> factors;  // of user factors
  FrameTimes times;
};

// Callbacks of SlamSystem; any may be empty. Called on the thread that calls Track(), Finish() or
// AdjustAll(), before it returns and when the system is in a consistent state: const members may be
// called, but none that changes it. An exception of a callback reaches the caller.
struct SlamCallbacks {
  // A keyframe was added to the map, with the image it was made from, its depth corrected as by
  // CorrectedDepth().
  std::function<void(const KeyFrame&, const RgbdImage&)> on_keyframe = {};
  // A loop was closed or rejected, or the adjustment after one is complete.
  std::function<void(const LoopReport&)> on_loop = {};
  // Tracking stayed lost, and the map continues in a new submap from this frame.
  std::function<void(SubmapId)> on_submap = {};
  // Two submaps were merged: the first report of the loop that merged them (merge), which on_loop
  // receives as well.
  std::function<void(const LoopReport&)> on_merge = {};
  // Keyframes have moved by more than a local adjustment: after a loop closure, a global
  // adjustment, an adjustment to corrected depth or to user factors, or when gravity was
  // initialized or its estimate improved much; or a submap was removed with its keyframes. Stored
  // poses or clouds must be updated from the map.
  std::function<void(const Map&)> on_map = {};
  // The keyframes for a dense map (DenseMapper::Apply). An event adds a keyframe, with its
  // corrected depth, 2 s after its frame, when the frames since have shown which objects moved in
  // it, or at Finish(); it holds the places of all keyframes if some have moved (as on_map), and
  // the ids of those that left the map. Images are copied and kept while they wait: set this before
  // the first frame. If this or a callback before it throws, the next event holds the same changes
  // again.
  std::function<void(const KeyframeEvent&)> on_keyframes = {};
  // Something contradicts the configuration of the sensors (verdict()), as soon as it is
  // significant.
  std::function<void(const SensorFinding&)> on_finding = {};
  // Every frame, including lost ones, after the above: the return value of Track().
  std::function<void(const FrameResult&)> on_frame = {};
};

// Counts of the user factors by state.
struct FactorCounts {
  std::size_t waiting = 0;   // for a frame at their stamp
  std::size_t attached = 0;  // to keyframes
  std::size_t refused = 0;   // no frame with a pose was near enough
  // Of those attached, the ones that were dropped because all of their stamps ended at one
  // keyframe: a motion within a keyframe constrains no pose of the map.
  std::size_t dropped = 0;
};

// What was postponed because images were waiting (SlamSystem::SetBacklog).
struct PostponedWork {
  std::size_t keyframes = 0;  // frames with which a keyframe was due and waited for an adjustment
  std::size_t loop_searches = 0;  // keyframes for which no loop was searched
};

// The velocity of a frame by all images, and by the readings of an IMU that is in use
// (docs/tracking.md, Smoothing).
struct FrameVelocity {
  Stamp stamp = 0;                                    // of the frame
  Eigen::Vector3d v_WC = Eigen::Vector3d::Zero();     // [m/s] of the camera's centre
  // [rad/s] along the axes of the camera; with an IMU in use a single reading of its gyroscope.
  Eigen::Vector3d omega_C = Eigen::Vector3d::Zero();
  // Of [v_WC; omega_C], given the keyframes: the drift of the map is not part of it.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

// Trajectory of the frames tracked in one world frame.
struct SubmapTrajectory {
  SubmapId submap = kNoId;                // root of the merged submaps
  std::size_t keyframes = 0;              // active
  Trajectory frames;                      // T_WC, as SlamSystem::trajectory()
  std::vector<FrameVelocity> velocities;  // as SlamSystem::velocities()
};

// [s] Maximum pause of a camera between two frames: a stamp that jumps farther is a clock fault,
// unless the next frame is consistent with it (SlamSystem::Track).
inline constexpr double kLongestPause = 86'400.0;

// What a SlamSystem may be given in addition to the sensor.
struct SlamInputs {
  // If given, every reading until some 50 ms after an image must be passed to AddImu() before that
  // image.
  std::optional<ImuCalibration> imu{};
  // Of the same camera, to continue in (LoadMap); tracking is lost until a frame is relocalized.
  Map map{};
  // A user-defined PointExtractor (docs/user_features.md) instead of
  // FrameBuilderOptions::point_detector; the points of a given map must have the same
  // FeatureType::name and the same pyramid.
  std::shared_ptr<PointExtractor> points{};
  // A user-defined LineExtractor instead of FrameBuilderOptions::lines. A map does not state how
  // its lines were described: those of a given map must be comparable.
  std::shared_ptr<LineExtractor> lines{};
  // A user-defined KeyFramePolicy instead of StandardKeyFramePolicy with SlamOptions::keyframes.
  std::shared_ptr<KeyFramePolicy> keyframe_policy{};
  // For the programs of Highwall, whose profile records the threads and stages of a run; null: none
  // is recorded. It must outlive the system.
  RunProfile* profile = nullptr;
};

// Point-line RGB-D(-inertial) SLAM: takes images and IMU readings, returns poses and keyframes.
// Local adjustments and loop closures are computed on threads of their own and applied between
// frames (SlamOptions::threads).
//
// World W: origin at the first camera, x along its optical axis, z up if the camera was held level;
// with an IMU z is always up, and the whole map is rotated slightly when gravity has been
// initialized. A frame that cannot be tracked is bridged by the IMU, else reported as lost and
// without a pose; the map is kept, and later frames are relocalized in it. If that fails for a
// short time (SubmapOptions), the map continues in a new submap with a world of its own; when that
// overlaps an older one, the two are merged by a loop closure.
class SlamSystem {
 public:
  // Throws InvalidArgument for bad options, and if localize_only is combined with an IMU or with no
  // map.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options = {}, SlamInputs inputs = {});
  // Cancels unfinished work on other threads.
  ~SlamSystem();
  SlamSystem(SlamSystem&&) noexcept;
  SlamSystem& operator=(SlamSystem&&) noexcept;

  // Sets the callbacks of the following calls.
  void SetCallbacks(SlamCallbacks callbacks);

  // Readings may arrive late or twice; the status of the reading is returned, and Advice() says
  // what to do if it was rejected (ImuBuffer::Add); other readings are still accepted. Throws
  // InvalidArgument if the system was created without an IMU.
  ImuSampleStatus AddImu(const ImuSample& sample);

  // Adds a reference frame of user factors.
  ReferenceFrameId AddReferenceFrame(const ReferenceFrame& frame = {});
  // Adds a user factor (docs/user_factors.md), in any order, before or after the frames of its
  // stamps. It takes part in local adjustments, loop closures and AdjustAll(), and moves the whole
  // map if that has drifted. Throws InvalidArgument if it is not as PoseFactor says, if its frame
  // is unknown, or if the system only localizes.
  void AddFactor(PoseFactor factor);
  // T_FW, the pose of F, in the world of trajectory(); empty as long as it is unknown.
  std::optional<Pose> T_FW(ReferenceFrameId frame) const;
  // Counts of all factors that were added.
  FactorCounts factor_counts() const;
  // The same for each PoseFactor::source, so that a sensor whose factors are all refused (another
  // clock, a wrong unit of its stamps) is not hidden by the others.
  std::map<std::string, FactorCounts> factor_counts_by_source() const;

  // Throws InvalidArgument if stamps do not ascend, images do not fit, or depth is not in metres; a
  // rejected frame has no effect. It also throws for a stamp more than kLongestPause after the
  // frame before, but only once, so that one wrong stamp does not block those that follow: the next
  // frame is accepted if it has the same stamp again, or follows it.
  FrameResult Track(const RgbdImage& image);

  // Sets the number of images that wait to be tracked, for a camera that does not wait; call it
  // before Track(). While there are any, that postpones what can wait: keyframes until the running
  // adjustment ends, unless too little is tracked; the search for loops, of two keyframes in three;
  // the refinement of frames and the calibration of depth. Recordings need not call it: 0 until it
  // is called.
  void SetBacklog(std::size_t images);
  // What was postponed so far.
  PostponedWork postponed() const;

  // Returns the dynamic mask of the image of an active keyframe (FrameResult::moving), from the
  // frames in the seconds before and since: a second or two later it is more complete than at
  // first.
  cv::Mat DynamicMaskOf(KeyFrameId keyframe) const;
  // Returns the depth [m] of an active keyframe's image, corrected by the current estimate, as the
  // keyframe's features are: without sensor().depth_pattern, and with rolling-shutter compensation
  // (docs/row_times.md). depth: CV_32FC1, as given to Track(), else throws InvalidArgument. For a
  // keyframe that is not from this run only the pattern is removed.
  cv::Mat CorrectedDepth(KeyFrameId keyframe, const cv::Mat& depth) const;

  // Returns an active keyframe in the form of on_keyframes, by the current estimates of its pose,
  // depth correction and dynamic objects. image: as it was given to Track(). Empty if there is no
  // such keyframe. Throws as CorrectedDepth().
  std::optional<KeyframeView> keyframe_view(KeyFrameId keyframe, const RgbdImage& image) const;
  // Returns the places of all keyframes and, if on_keyframes is set, the changes that it has not
  // received yet.
  KeyframeEvent waiting_keyframes() const;

  // To be called at the end of a run: waits for the running adjustment and loop closure, if any,
  // and applies both to the map, and then new user factors, also those added after the last frame;
  // closes a loop and merges submaps by the newest keyframes, which no more will confirm; refines
  // the poses of the last frames and smooths all of them over time. A factor with a stamp after the
  // last frame with a pose still waits.
  std::vector<LoopReport> Finish();
  // After Finish(): runs one more adjustment of all keyframes and landmarks together, with the user
  // factors added until then. The poses of frames follow their keyframes. Throws InvalidArgument if
  // the system only localizes.
  BundleAdjustmentReport AdjustAll();

  // T_WC of every tracked frame after all adjustments so far: a frame keeps its pose relative to
  // the keyframe it was tracked or refined against (SlamOptions::refinement; the last of them by
  // Finish(), which also smooths all). In the world of the first of submaps(); empty if there is
  // none.
  Trajectory trajectory() const;
  // The velocities of the frames of trajectory(), by stamp; empty before Finish(), and without
  // SlamOptions::refinement.smooth. Frames have none where they are too few, too far apart to be
  // smoothed, or, with an IMU in use, beside readings that are missing or contradicted by images.
  std::vector<FrameVelocity> velocities() const;
  // T_WC of the active keyframes of this run, without those of a given map, in that world.
  Trajectory keyframe_trajectory() const;
  // One trajectory per world in which frames were tracked and that still exists, most frames first.
  std::vector<SubmapTrajectory> submaps() const;

  // Online estimate of the noise, the row times and the depth distortion of the sensor.
  SensorEstimate sensor() const;
  // What contradicts the configuration of the sensors so far; complete after Finish().
  SensorVerdict verdict() const;
  // Number of frames whose pose was refined afterwards (SlamOptions::refinement).
  int refined_frames() const;

  // What the parts of the system hold in memory, most of it in the map. Work in progress on copies
  // of the map is not counted.
  std::vector<MemoryShare> memory() const;

  const Map& map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
