#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "support/synthetic_scene.h"
#include "tracking/tracker.h"

namespace highwall::testing {

// Returns a pose on a loop of 20 cm within 60 frames, with up to 2 cm and half a degree a frame.
inline Pose PoseOfFrame(int i) {
  const double phase = i * 2.0 * M_PI / 60.0;
  return Pose::FromTangent({0.2 * std::sin(phase), 0.1 * (1.0 - std::cos(phase)), 0.0},
                           {0.02 * std::sin(2 * phase), 0.08 * std::sin(phase), 0.0});
}

// Returns a noise of all kinds of detected features twice the a priori one.
inline NoiseEstimate TwiceTheNoise() {
  NoiseEstimate noise;
  noise.point_px.fill(2.0);
  noise.low_contrast_px.fill(2.0);
  for (auto* bands : {&noise.point_depth, &noise.edge_depth, &noise.line_px, &noise.line_depth}) {
    bands->fill(2.0);
  }
  return noise;
}

struct OwnedSensor {
  SensorModel sensor;
};

// A tracker as the system runs it: the landmarks of a frame are counted in the map, and the
// sensor learns from its motion.
class TrackerInSystem : public OwnedSensor, public Tracker {
 public:
  TrackerInSystem(const MeasurementModel& model, const TrackerOptions& options,
                  const FrameTiming& timing = {}, const TrackerParameters& parameters = {})
      : OwnedSensor{{model, SensorOptions(options), timing}},
        Tracker(model, options, sensor, parameters) {}

  void Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe) {
    Tracker::Anchor(tracked, keyframe);
    sensor.Remember(keyframe, moved_by());
  }
  TrackedFrame Track(const Frame& frame, Map& map,
                     const std::optional<PoseConstraint>& predicted = std::nullopt) {
    TrackingResult result = Tracker::Track(frame, map, predicted);
    result.counts.AddTo(&map);
    const TrackedFrame& tracked = result.frame;
    if (result.motion) {
      sensor.LearnTiming(
          {tracked.frame.stamp, *tracked.frame.features, tracked.points, tracked.T_WC}, map,
          *result.motion);
    }
    return std::move(result.frame);
  }
};

// A tracker in a scene that two keyframes have mapped.
class TrackerTest : public ::testing::Test {
 protected:
  explicit TrackerTest(int points = 500, int lines = 40, bool keyframes = true)
      : scene(MakeScene(15, points, lines)), scene_map(scene) {
    if (!keyframes) return;
    // Two keyframes see all that the path will see.
    for (const Pose& T_WC : {Pose::FromTangent({-0.1, 0, -0.4}, {0, 0, 0}),
                             Pose::FromTangent({0.1, 0.1, -0.4}, {0, 0.05, 0})}) {
      scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    }
  }

  // As in the system, the first frame becomes the keyframe.
  void Start(TrackerInSystem& tracker, const Pose& T_WC) {
    const SyntheticView view = Look(scene, IdealSensor(), T_WC);
    const KeyFrameId id = scene_map.Add(view, T_WC);
    TrackedFrame tracked;
    tracked.frame = MakeFrame(view, 0);
    tracked.T_WC = T_WC;
    tracker.Anchor(tracked, *scene_map.map.keyframe(id));
  }
  TrackedFrame Track(TrackerInSystem& tracker, const SyntheticView& view, int index = 1) {
    return tracker.Track(MakeFrame(view, index), scene_map.map);
  }
  void ExpectAt(const TrackedFrame& tracked, const Pose& truth, double tolerance) const {
    ASSERT_EQ(tracked.state, TrackingState::kTracking);
    EXPECT_LT(PositionError(tracked.T_WC, truth), tolerance);
    EXPECT_LT(AngleError(tracked.T_WC, truth), tolerance);
  }

  const MeasurementModel model{IdealSensor(), {}};
  const Scene scene;
  SceneMap scene_map;
  const Scene foreign = MakeScene(99, 500, 40);
};

}  // namespace highwall::testing
