#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/frame.h>
#include <highwall/frontend/imu_calibration.h>
#include <highwall/frontend/inertial_odometry.h>
#include <highwall/frontend/keyframe_policy.h>
#include <highwall/frontend/local_mapper.h>
#include <highwall/frontend/loop_closer.h>
#include <highwall/frontend/map.h>
#include <highwall/frontend/measurement_model.h>
#include <highwall/frontend/sensor.h>
#include <highwall/frontend/tracker.h>

namespace highwall {

struct SlamOptions {
  FrameBuilderOptions frame{};
  MeasurementOptions measurement{};
  TrackerOptions tracker{};
  KeyFramePolicyOptions keyframes{};
  LocalMapperOptions mapper{};
  InertialOptions inertial{};  // where there is an IMU
  LoopCloserOptions loops{};

  // Also where two fields contradict each other (the pyramid of frame.orb and of measurement).
  void Validate() const;
};

// Milliseconds of one frame. features: points and lines together, which overlap in time.
struct FrameTimes {
  double points = 0.0, lines = 0.0, features = 0.0;
  double tracking = 0.0;  // pose estimation, features not included
  double mapping = 0.0;   // local mapping, on keyframes
  double loops = 0.0;     // what loops take from the caller's time
};

struct FrameResult {
  Stamp stamp = 0;
  TrackingState state = TrackingState::kLost;
  bool relocalized = false;
  Pose T_WC;                  // causal estimate; meaningful where HasPose(state)
  int points = 0, lines = 0;  // features extracted
  int matched_points = 0, matched_lines = 0;
  // What moves, as the past tells: CV_8UC1 of the image, 255; empty where nothing does. Its
  // features make no pose and no landmarks.
  cv::Mat moving;
  std::optional<LocalMappingReport> mapping;  // where the frame became a keyframe
  std::optional<InertialReport> inertial;     // with an IMU
  std::vector<LoopReport> loops;              // what was applied to the map since the last frame
  FrameTimes times;
};

// Point-line RGB-D(-inertial) odometry with a map: images and the readings of an IMU in, poses and
// keyframes out. Loops are closed in the background and applied between frames. With
// loops.background = false and one thread in mapper.bundle and loops the same input gives the same
// output, bit for bit.
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
  // map: of the same camera, to go on in (LoadMap): lost until a frame is recognized.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options,
             const std::optional<ImuCalibration>& imu, Map map = {});
  SlamSystem(const SlamSystem&) = delete;
  SlamSystem& operator=(const SlamSystem&) = delete;

  // Readings may come late or twice; what became of one is returned. Throws InvalidArgument where
  // the system was made without an IMU.
  ImuSampleStatus AddImu(const ImuSample& sample);

  // Stamps must ascend. Throws InvalidArgument where they do not or the images do not fit.
  FrameResult Track(const RgbdImage& image);

  // What moves in the image of a live keyframe (FrameResult::moving), by what was seen in the
  // seconds before and since: a second or two later more is known than at once.
  cv::Mat MovingIn(KeyFrameId keyframe) const;

  // Waits for the loop that is being closed, if any, and applies it to the map.
  std::vector<LoopReport> Finish();
  // After Finish(): one more adjustment of all keyframes and landmarks together. Frames follow.
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
  std::optional<KeyFrameMotion> MotionSince(const KeyFrame* last) const;
  // Changes the map and lets the tracker follow its reference keyframe.
  template <class Change>
  auto WithTracker(const Change& change);
  // Applies what loops have come to.
  std::vector<LoopReport> UpdateLoops();

  SlamOptions options_;
  MeasurementModel model_;
  FrameBuilder builder_;
  Tracker tracker_;
  KeyFramePolicy policy_;
  LocalMapper mapper_;
  std::optional<InertialOdometry> inertial_;
  LoopCloser loop_closer_;
  Map map_;
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
