#include <highwall/frontend/slam_system.h>

#include <chrono>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

namespace highwall {
namespace {

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
        .count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// W has z up and x forward for a camera held level (x right, y down, z forward).
Pose FirstPose() {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Pose::FromMatrix(T);
}

}  // namespace

void SlamOptions::Validate() const {
  frame.Validate();
  measurement.Validate();
  tracker.Validate();
  keyframes.Validate();
  mapper.Validate();
  loops.Validate();
  HIGHWALL_REQUIRE(frame.orb.scale_factor == measurement.scale_factor,
                   "SlamOptions: frame.orb.scale_factor and measurement.scale_factor differ");
}

SlamSystem::SlamSystem(const RgbdSensor& sensor, const SlamOptions& options)
    : options_((options.Validate(), options)),
      model_(sensor, options.measurement),
      builder_(sensor, options.frame),
      tracker_(model_, options.frame.orb.levels, options.tracker),
      policy_(options.keyframes),
      mapper_(model_, options.frame.orb.levels, options.mapper),
      loop_closer_(model_, options.frame.orb.levels, options.loops) {}

SlamSystem::SlamSystem(const RgbdSensor& sensor, const SlamOptions& options, Map map)
    : SlamSystem(sensor, options) {
  map_ = std::move(map);
  const auto ids = map_.keyframe_ids();
  if (!ids.empty()) first_own_keyframe_ = ids.back() + 1;
}

FrameResult SlamSystem::Track(const RgbdImage& image) {
  HIGHWALL_REQUIRE(!last_stamp_ || image.stamp > *last_stamp_,
                   "SlamSystem::Track: stamp " + FormatStamp(image.stamp) + " is not after " +
                       FormatStamp(last_stamp_.value_or(0)));
  FrameResult result;
  result.stamp = image.stamp;

  const Stopwatch features_watch;
  FrameBuilderTimes builder_times;
  const auto features = builder_.Build(image, &builder_times);
  // From here on the image counts; one that was refused leaves no trace.
  const Frame frame{next_index_++, image.stamp, features};
  last_stamp_ = image.stamp;
  result.times.features = features_watch.Milliseconds();
  result.times.points = builder_times.points;
  result.times.lines = builder_times.lines;
  result.points = static_cast<int>(frame.features->points.size());
  result.lines = static_cast<int>(frame.features->lines.size());

  const Stopwatch loops_watch;
  result.loops = UpdateLoops();
  result.times.loops = loops_watch.Milliseconds();

  const Stopwatch tracking_watch;
  TrackedFrame tracked = tracker_.Track(frame, map_);
  result.times.tracking = tracking_watch.Milliseconds();
  if (tracked.state == TrackingState::kInitializing && policy_.CanStart(*frame.features)) {
    tracked.state = TrackingState::kTracking;
    tracked.T_WC = FirstPose();
    InsertKeyFrame(tracked, result);
  } else if (tracked.state == TrackingState::kTracking &&
             policy_.Wants(tracked, map_, last_keyframe_index_)) {
    InsertKeyFrame(tracked, result);
  }

  result.state = tracked.state;
  result.relocalized = tracked.relocalized;
  result.T_WC = tracked.T_WC;
  result.matched_points = tracked.num_points;
  result.matched_lines = tracked.num_lines;
  if (tracked.state == TrackingState::kTracking) {
    tracked_.push_back({image.stamp, tracked.reference,
                        map_.keyframe(tracked.reference)->T_WC.Inverse() * tracked.T_WC});
  }
  return result;
}

void SlamSystem::InsertKeyFrame(TrackedFrame& tracked, FrameResult& result) {
  const Stopwatch watch;
  result.mapping = mapper_.InsertKeyFrame(tracked, map_);
  last_keyframe_index_ = tracked.frame.index;
  const KeyFrame& keyframe = *map_.keyframe(result.mapping->keyframe);
  tracked.T_WC = keyframe.T_WC;
  tracked.reference = keyframe.id;
  tracker_.Anchor(tracked, keyframe);
  result.times.mapping = watch.Milliseconds();

  const Stopwatch loops_watch;
  if (loop_closer_.InsertKeyFrame(map_, keyframe.id)) {
    // In lockstep the loop is closed by now, and the frame belongs to the corrected map.
    for (LoopReport& report : UpdateLoops()) result.loops.push_back(std::move(report));
    tracked.T_WC = keyframe.T_WC;
  }
  result.times.loops += loops_watch.Milliseconds();
}

template <class Change>
auto SlamSystem::WithTracker(const Change& change) {
  const auto reference = tracker_.reference();
  const Pose before = reference ? map_.ResolvePose(*reference) : Pose();
  auto result = change();
  if (reference) tracker_.Transform(map_.ResolvePose(*reference) * before.Inverse());
  return result;
}

std::vector<LoopReport> SlamSystem::UpdateLoops() {
  if (!loop_closer_.HasNews()) return {};
  return WithTracker([&] { return loop_closer_.Update(&map_); });
}

std::vector<LoopReport> SlamSystem::Finish() {
  return WithTracker([&] { return loop_closer_.Finish(&map_); });
}

BundleAdjustmentReport SlamSystem::AdjustAll() {
  return WithTracker(
      [&] { return AdjustBundle(map_, model_, map_.keyframe_ids(), {}, options_.loops.bundle); });
}

Trajectory SlamSystem::trajectory() const {
  Trajectory trajectory;
  trajectory.reserve(tracked_.size());
  for (const Tracked& t : tracked_) {
    trajectory.push_back({t.stamp, map_.ResolvePose(t.reference) * t.T_reference_C});
  }
  return trajectory;
}

Trajectory SlamSystem::keyframe_trajectory() const {
  Trajectory trajectory;
  for (const KeyFrameId id : map_.keyframe_ids()) {
    if (id < first_own_keyframe_) continue;
    trajectory.push_back({map_.keyframe(id)->frame.stamp, map_.keyframe(id)->T_WC});
  }
  return trajectory;
}

}  // namespace highwall
