#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/pose/degeneracy.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/imu_calibration.h>
#include <highwall/frontend/inertial/inertial_odometry.h>
#include <highwall/frontend/tracking/keyframe_policy.h>
#include <highwall/frontend/local/local_mapper.h>
#include <highwall/frontend/loops/loop_closer.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/tracking/tracker.h>

namespace highwall {

struct SlamOptions {
  FrameBuilderOptions frame{};
  MeasurementOptions measurement{};
  TrackerOptions tracker{};
  KeyFramePolicyOptions keyframes{};
  LocalMapperOptions mapper{};
  InertialOptions inertial{};  // where there is an IMU
  LoopCloserOptions loops{};
  // The map that is given stays as it is, but for how often its landmarks were looked for and
  // found: frames find their pose in it, none becomes a keyframe. Images alone, without an IMU.
  bool localize_only = false;

  // Also where two fields contradict each other (the pyramid of frame.orb and of measurement).
  void Validate() const;
};

// Milliseconds of one frame. features: points and lines together, which overlap in time.
struct FrameTimes {
  double points = 0.0, lines = 0.0, features = 0.0;
  double tracking = 0.0;  // pose estimation, features not included
  double mapping = 0.0;   // local mapping, on keyframes, as far as the caller does it
  double loops = 0.0;     // applying what other threads have come to, and looking for loops
};

struct FrameResult {
  Stamp stamp = 0;
  TrackingState state = TrackingState::kLost;
  bool relocalized = false;
  Pose T_WC;                  // causal estimate; meaningful where HasPose(state)
  int points = 0, lines = 0;  // features extracted
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
  FrameTimes times;
};

// The options with everything on the caller's thread, in lockstep: the same input then gives the
// same output, bit for bit.
SlamOptions Deterministic(SlamOptions options);

// What a SlamSystem tells while it works; any may be empty. Called on the thread that calls
// Track(), Finish() or AdjustAll(), before it returns and when the system is whole again: const
// members may be asked, none that changes it. What a callback throws reaches the caller.
struct SlamCallbacks {
  // A keyframe has joined the map, and the image it was made from.
  std::function<void(const KeyFrame&, const RgbdImage&)> on_keyframe = {};
  // A loop was closed or refused, or the adjustment after one is done.
  std::function<void(const LoopReport&)> on_loop = {};
  // Keyframes have moved by more than a local adjustment: after a loop, an adjustment of
  // everything, or when gravity was found. Whoever keeps poses or clouds asks the map again.
  std::function<void(const Map&)> on_map = {};
  // Every frame, lost ones included, after the above: what Track() returns.
  std::function<void(const FrameResult&)> on_frame = {};
};

// Point-line RGB-D(-inertial) odometry with a map: images and the readings of an IMU in, poses and
// keyframes out. Local adjustments and loops are computed on threads of their own and applied
// between frames (SlamOptions::mapper, loops; Deterministic()).
//
// World W: origin at the first camera, x along its optical axis, z up where the camera was held
// level; with an IMU z is up in any case, and the whole map turns a little when it has found where
// up is. A frame that cannot be tracked is bridged by the IMU, else reported as lost and without a
// pose; the map stays, and later frames are relocalized in it.
class SlamSystem {
 public:
  // Throws InvalidArgument on bad options.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options = {});
  // imu: with one every reading until some 50 ms after an image goes to AddImu() before that image.
  // map: of the same camera, to go on in (LoadMap): lost until a frame is recognized. Throws
  // InvalidArgument also where localize_only comes with an IMU or without a map.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options,
             const std::optional<ImuCalibration>& imu, Map map = {});
  SlamSystem(const SlamSystem&) = delete;
  SlamSystem& operator=(const SlamSystem&) = delete;

  // For the calls that follow.
  void SetCallbacks(SlamCallbacks callbacks) { callbacks_ = std::move(callbacks); }

  // Readings may come late or twice; what became of one is returned. Throws InvalidArgument where
  // the system was made without an IMU.
  ImuSampleStatus AddImu(const ImuSample& sample);

  // Stamps must ascend. Throws InvalidArgument where they do not or the images do not fit.
  FrameResult Track(const RgbdImage& image);

  // What moves in the image of a live keyframe (FrameResult::moving), by what was seen in the
  // seconds before and since: a second or two later more is known than at once.
  cv::Mat MovingIn(KeyFrameId keyframe) const;

  // Waits for what is being adjusted and for the loop that is being closed, if any, and applies
  // both to the map.
  std::vector<LoopReport> Finish();
  // After Finish(): one more adjustment of all keyframes and landmarks together. Frames follow.
  // Throws InvalidArgument where the system localizes only.
  BundleAdjustmentReport AdjustAll();

  // T_WC of every tracked frame after all adjustments so far: a frame keeps its pose relative to
  // the keyframe it was tracked against.
  Trajectory trajectory() const;
  // T_WC of the live keyframes of this run, without those of a map that was given.
  Trajectory keyframe_trajectory() const;

  const Map& map() const { return map_; }
  // Null without an IMU.
  const InertialOdometry* inertial() const { return inertial_ ? &*inertial_ : nullptr; }

 private:
  struct Tracked {
    Stamp stamp = 0;
    KeyFrameId reference = kNoId;
    Pose T_reference_C;
  };

  // Cells that move as pixels, their border included; empty where there are none.
  cv::Mat ToImage(const cv::Mat& moving) const;
  Pose FirstPose(Stamp stamp) const;
  // Fuses the frame with the IMU.
  void Fuse(TrackedFrame& tracked, FrameResult& result);
  bool WantsKeyFrame(const TrackedFrame& tracked) const;
  void InsertKeyFrame(TrackedFrame& tracked, FrameResult& result);
  void LookForLoop(TrackedFrame& tracked, FrameResult& result);
  std::optional<KeyFrameMotion> MotionSince(const KeyFrame* last) const;
  // Changes the map and lets tracker and odometry follow: by how the reference keyframe moved.
  template <class Change>
  Pose WithTracker(const Change& change);
  // Applies what the other threads have come to.
  void ApplyNews(FrameResult& result);
  void Tell(const FrameResult& result, const RgbdImage& image) const;
  void Tell(const std::vector<LoopReport>& loops) const;

  SlamOptions options_;
  MeasurementModel model_;
  FrameBuilder builder_;
  Tracker tracker_;
  KeyFramePolicy policy_;
  LocalMapper mapper_;
  std::optional<InertialOdometry> inertial_;
  LoopCloser loop_closer_;
  Map map_;
  SlamCallbacks callbacks_;
  std::vector<Tracked> tracked_;
  std::optional<Stamp> last_stamp_;
  KeyFrameId first_own_keyframe_ = 0;  // those before came with the map
  std::int64_t next_index_ = 0;
  std::int64_t last_keyframe_index_ = 0;
  KeyFrameId last_keyframe_ = kNoId;
  std::int64_t last_visual_index_ = 0;  // of the last frame whose image told its pose
  int last_points_ = 0;                 // matched in the last frame
  double usual_sharpness_ = 0.0;
};

}  // namespace highwall
