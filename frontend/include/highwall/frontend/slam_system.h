#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/frame.h>
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
  Pose T_WC;                  // causal estimate; meaningful in kTracking
  int points = 0, lines = 0;  // features extracted
  int matched_points = 0, matched_lines = 0;
  std::optional<LocalMappingReport> mapping;  // where the frame became a keyframe
  std::vector<LoopReport> loops;              // what was applied to the map since the last frame
  FrameTimes times;
};

// Point-line RGB-D odometry with a map: images in, poses and keyframes out. Loops are
// closed in the background and applied between frames. With loops.background = false and one thread
// in mapper.bundle and loops the same input gives the same output, bit for bit.
//
// World W: origin at the first camera, x along its optical axis, z up where the camera was held
// level. A frame that cannot be tracked is reported as lost and has no pose; the map stays, and
// later frames are relocalized in it.
class SlamSystem {
 public:
  // Throws InvalidArgument on bad options.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options = {});
  // Goes on in a map of the same camera (LoadMap): lost until a frame is recognized.
  SlamSystem(const RgbdSensor& sensor, const SlamOptions& options, Map map);
  SlamSystem(const SlamSystem&) = delete;
  SlamSystem& operator=(const SlamSystem&) = delete;

  // Stamps must ascend. Throws InvalidArgument where they do not or the images do not fit.
  FrameResult Track(const RgbdImage& image);

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

 private:
  struct Tracked {
    Stamp stamp = 0;
    KeyFrameId reference = kNoId;
    Pose T_reference_C;
  };

  void InsertKeyFrame(TrackedFrame& tracked, FrameResult& result);
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
  LoopCloser loop_closer_;
  Map map_;
  std::vector<Tracked> tracked_;
  std::optional<Stamp> last_stamp_;
  KeyFrameId first_own_keyframe_ = 0;  // those before came with the map
  std::int64_t next_index_ = 0;
  std::int64_t last_keyframe_index_ = 0;
};

}  // namespace highwall
