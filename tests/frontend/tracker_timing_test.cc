#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <gtest/gtest.h>

#include <highwall/core/stamp.h>

#include "features/row_times.h"
#include "tracker_fixture.h"

namespace highwall::tracker_timing_test {
namespace {

using testing::AngleError;
using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::PoseOfFrame;
using testing::PositionError;
using testing::SyntheticView;
using testing::TrackerInSystem;
using testing::TrackerTest;
using testing::ViewNoise;

constexpr double kReadout = 0.025;  // [s]

class TrackerTiming : public TrackerTest {
 protected:
  // Returns frame i of a rolling shutter with readout kReadout, with the motion from the previous
  // frame.
  SyntheticView SeenByRows(int i, ReadoutDirection direction = ReadoutDirection::kDown) const {
    const RgbdSensor sensor = IdealSensor();
    SyntheticView view = Look(scene, sensor, PoseOfFrame(i),
                              {.px = 0.5, .depth = true, .seed = static_cast<unsigned>(i)});
    const double dt = ToSeconds(MakeFrame(view, i).stamp - MakeFrame(view, i - 1).stamp);
    const Twist motion = Twist::Between(PoseOfFrame(i - 1).Inverse() * PoseOfFrame(i), dt);
    // Backwards in time: the observation is that of one instant moved to the rows, to a tenth of a
    // pixel.
    view.features =
        CompensatedToMiddleRow(*view.features, sensor.camera, -kReadout, motion, direction);
    return view;
  }

  // Returns the motion at frame i of a shaking camera, which no step between images reveals.
  static Twist Shaken(int i) {
    Twist motion = Twist::Between(PoseOfFrame(i - 1).Inverse() * PoseOfFrame(i), 1.0 / 30.0);
    motion.omega.z() += i % 2 == 0 ? 1.0 : -1.0;
    return motion;
  }

  // Tracks frame i, for which the IMU predicts this motion.
  TrackedFrame TrackPredicted(TrackerInSystem& tracker, int i) {
    PoseConstraint known{PoseOfFrame(i)};
    known.motion = Shaken(i);
    return tracker.Track(MakeFrame(SeenByRows(i), i), scene_map.map, known);
  }

  // Returns whether a keyframe made of the result of `track`, some frame after the fourth, is left
  // unchanged after the next frame.
  bool StaysAsItWas(const std::function<TrackedFrame(TrackerInSystem&)>& track) {
    TrackerInSystem tracker(model, {.timing = FrameTimingMode::kKnown},
                            {.colour_readout = kReadout});
    Start(tracker, PoseOfFrame(0));
    for (int i = 1; i < 5; ++i) Track(tracker, SeenByRows(i), i);
    const TrackedFrame tracked = track(tracker);
    EXPECT_EQ(tracked.state, TrackingState::kTracking);
    const int i = static_cast<int>(tracked.frame.index);
    KeyFrame& keyframe = *scene_map.map.keyframe(scene_map.Add(SeenByRows(i), tracked.T_WC));
    keyframe.frame = tracked.frame;
    tracker.Anchor(tracked, keyframe);
    Track(tracker, SeenByRows(i + 1), i + 1);
    const auto before = keyframe.frame.features;
    tracker.sensor.CompensateAll(&scene_map.map);
    return keyframe.frame.features == before;
  }

  // Tracks 240 frames and returns the RMS position error [m] of the last 60.
  double Follow(TrackerInSystem& tracker, ReadoutDirection direction = ReadoutDirection::kDown) {
    Start(tracker, PoseOfFrame(0));
    double sum = 0.0;
    for (int i = 1; i < 240; ++i) {
      const TrackedFrame tracked = Track(tracker, SeenByRows(i, direction), i);
      EXPECT_EQ(tracked.state, TrackingState::kTracking) << i;
      if (i >= 180) sum += std::pow(PositionError(tracked.T_WC, PoseOfFrame(i)), 2);
    }
    return std::sqrt(sum / 60.0);
  }
};

TEST_F(TrackerTiming, FindsTheReadoutAndItsPosesAreAsGoodAsWithTheKnownOne) {
  TrackerInSystem ignoring(model, {.timing = FrameTimingMode::kIgnored});
  TrackerInSystem knowing(model, {.timing = FrameTimingMode::kKnown}, {.colour_readout = kReadout});
  TrackerInSystem estimating(model, {});
  const double ignored = Follow(ignoring), known = Follow(knowing), found = Follow(estimating);
  EXPECT_LT(known, 0.5 * ignored);
  EXPECT_LT(found, 1.1 * known);
  const FrameTimingEstimate estimate = estimating.sensor.timing_estimate();
  EXPECT_NEAR(estimate.value.colour_readout, kReadout,
              std::max(0.1 * kReadout, 3.0 * estimate.sigma.colour_readout));
  EXPECT_LT(estimate.sigma.colour_readout, 2e-3);
  // Features without a depth grid contain no information on the time of depth.
  EXPECT_EQ(estimate.value.depth_readout, 0.0);
  EXPECT_EQ(estimate.value.depth_delay, 0.0);
  EXPECT_GT(estimate.sigma.depth_delay, 5e-3);
  EXPECT_EQ(knowing.sensor.timing().colour_readout, kReadout);
}

TEST_F(TrackerTiming, FindsTheReadoutAlongTheColumnsOfATurnedImage) {
  TrackerInSystem upright(model, {});
  TrackerInSystem turned(model, {}, {.direction = ReadoutDirection::kLeft});
  const double of_rows = Follow(upright), of_columns = Follow(turned, ReadoutDirection::kLeft);
  // Each is some 0.1 mm, by the noise of one image; rows in place of columns are six times that.
  EXPECT_LT(of_columns, 1.5 * of_rows);
  const FrameTimingEstimate estimate = turned.sensor.timing_estimate();
  EXPECT_EQ(estimate.value.direction, ReadoutDirection::kLeft);
  EXPECT_NEAR(estimate.value.colour_readout, kReadout,
              std::max(0.1 * kReadout, 3.0 * estimate.sigma.colour_readout));
}

TEST_F(TrackerTiming, ImagesOfOneTimeHaveNoReadout) {
  TrackerInSystem tracker(model, {});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 240; ++i) {
    Track(tracker,
          Look(scene, IdealSensor(), PoseOfFrame(i),
               {.px = 0.5, .depth = true, .seed = static_cast<unsigned>(i)}),
          i);
  }
  EXPECT_LT(tracker.sensor.timing().colour_readout, 1e-3);
}

TEST_F(TrackerTiming, KeepsAKnownReadoutWithinTwoStandardDeviations) {
  TrackerInSystem tracker(model, {}, {.colour_readout = kReadout});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 120; ++i) {
    Track(tracker, SeenByRows(i), i);
    const FrameTimingEstimate estimate = tracker.sensor.timing_estimate();
    const double off = std::abs(estimate.value.colour_readout - kReadout);
    // Two standard deviations: five of a hundred such numbers are further off by chance.
    if (off < 2.0 * estimate.sigma.colour_readout) {
      EXPECT_EQ(tracker.sensor.timing().colour_readout, kReadout) << i;
    } else {
      EXPECT_EQ(tracker.sensor.timing().colour_readout, estimate.value.colour_readout) << i;
    }
  }
}

TEST_F(TrackerTiming, AKeyframeMadeBeforeTheReadoutWasFoundFollowsIt) {
  TrackerInSystem tracker(model, {});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 10; ++i) Track(tracker, SeenByRows(i), i);
  const SyntheticView view = SeenByRows(10);
  TrackedFrame tracked = Track(tracker, view, 10);
  const KeyFrameId id = scene_map.Add(view, tracked.T_WC);
  KeyFrame& keyframe = *scene_map.map.keyframe(id);
  keyframe.frame = tracked.frame;
  tracker.Anchor(tracked, keyframe);
  for (int i = 11; i < 240; ++i) Track(tracker, SeenByRows(i), i);
  tracker.sensor.CompensateAll(&scene_map.map);
  const SyntheticView truth =
      Look(scene, IdealSensor(), PoseOfFrame(10), {.px = 0.5, .depth = true, .seed = 10});
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < truth.points.size(); ++i) {
    const Eigen::Vector2d& uv = truth.features->points[i].uv;
    before = std::max(before, (view.features->points[i].uv - uv).norm());
    after = std::max(after, (keyframe.frame.features->points[i].uv - uv).norm());
  }
  EXPECT_GT(before, 2.0);
  EXPECT_LT(after, 0.3 * before);
}

// A shaking camera rotates at an image in a way that no step between images reveals.
TEST_F(TrackerTiming, RowsFollowTheMotionThatTheImuPredicts) {
  const RgbdSensor sensor = IdealSensor();
  const auto follow = [&](bool predicted, double readout) {
    TrackerInSystem tracker(model, {.timing = FrameTimingMode::kKnown},
                            {.colour_readout = readout});
    Start(tracker, PoseOfFrame(0));
    double sum = 0.0;
    for (int i = 1; i < 40; ++i) {
      PoseConstraint known{PoseOfFrame(i)};
      known.motion = Shaken(i);
      SyntheticView view = Look(scene, sensor, PoseOfFrame(i), {.px = 0.5, .depth = true});
      view.features =
          CompensatedToMiddleRow(*view.features, sensor.camera, -readout, *known.motion);
      const Twist expected = *known.motion;
      if (!predicted) known.motion.reset();
      const TrackedFrame tracked = tracker.Track(MakeFrame(view, i), scene_map.map, known);
      EXPECT_EQ(tracked.state, TrackingState::kTracking) << i;
      EXPECT_EQ(tracker.Motion(&known).omega == expected.omega, predicted) << i;
      sum += std::pow(AngleError(tracked.T_WC, PoseOfFrame(i)), 2);
    }
    return std::sqrt(sum / 39.0);
  };
  // The first frame, whose motion is unknown, is the same in all.
  const double at_once = follow(true, 0.0), by_rows = follow(true, kReadout);
  EXPECT_LT(by_rows, 1.1 * at_once);
  EXPECT_GT(follow(false, kReadout), 3.0 * by_rows);
}

TEST_F(TrackerTiming, EstimatesTheReadoutFromTheMotionThatTheImuPredicts) {
  TrackerInSystem tracker(model, {});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 120; ++i) {
    PoseConstraint known{PoseOfFrame(i)};
    known.motion = Twist::Between(PoseOfFrame(i - 1).Inverse() * PoseOfFrame(i), 1.0 / 30.0);
    known.motion->v *= 1.5;  // by the step the read-out would be 1.5 times the true one
    known.motion->omega *= 1.5;
    SyntheticView view = Look(scene, IdealSensor(), PoseOfFrame(i),
                              {.px = 0.5, .depth = true, .seed = static_cast<unsigned>(i)});
    view.features =
        CompensatedToMiddleRow(*view.features, IdealSensor().camera, -kReadout, *known.motion);
    tracker.Track(MakeFrame(view, i), scene_map.map, known);
  }
  const FrameTimingEstimate estimate = tracker.sensor.timing_estimate();
  EXPECT_NEAR(estimate.value.colour_readout, kReadout, 0.1 * kReadout);
}

// The step after a keyframe gives a better motion than the step before, but not a better one than
// an IMU.
TEST_F(TrackerTiming, AKeyframeKeepsTheMotionThatTheImuPredicted) {
  EXPECT_TRUE(StaysAsItWas([&](TrackerInSystem& tracker) { return TrackPredicted(tracker, 5); }));
  EXPECT_FALSE(
      StaysAsItWas([&](TrackerInSystem& tracker) { return Track(tracker, SeenByRows(5), 5); }));
}

TEST_F(TrackerTiming, DoesNotKeepAMotionThatImagesContradict) {
  EXPECT_FALSE(StaysAsItWas([&](TrackerInSystem& tracker) {
    PoseConstraint known{PoseOfFrame(5)};
    known.motion = Shaken(5);
    known.motion->v.z() += 30.0;  // readings of an impact on the sensor
    return tracker.Track(MakeFrame(SeenByRows(5), 5), scene_map.map, known);
  }));
}

TEST_F(TrackerTiming, AMotionThatTheImuPredictedHoldsForItsFrameOnly) {
  EXPECT_FALSE(StaysAsItWas([&](TrackerInSystem& tracker) {
    TrackPredicted(tracker, 5);
    tracker.Forget();
    return Track(tracker, SeenByRows(6), 6);
  }));
}

TEST_F(TrackerTiming, ACutInARecordingIsNoMotion) {
  TrackerInSystem tracker(model, {.timing = FrameTimingMode::kKnown}, {.colour_readout = kReadout});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 20; ++i) Track(tracker, SeenByRows(i), i);
  // Frame 50 replaces frame 20: 30 cm within the time of one image.
  const SyntheticView cut = Look(scene, IdealSensor(), PoseOfFrame(50));
  const TrackedFrame tracked = Track(tracker, cut, 20);
  ASSERT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_EQ(tracker.Motion(nullptr).v, Eigen::Vector3d::Zero());
}

TEST_F(TrackerTiming, AFrameThatWasNotTrackedIsRememberedAsItWasSeen) {
  TrackerInSystem tracker(model, {.timing = FrameTimingMode::kKnown}, {.colour_readout = kReadout});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 10; ++i) Track(tracker, SeenByRows(i), i);
  tracker.Forget();
  const TrackedFrame lost = Track(tracker, Look(foreign, IdealSensor(), PoseOfFrame(10)), 10);
  ASSERT_EQ(lost.state, TrackingState::kLost);
  // As in the system, it begins another part of the map.
  KeyFrame& keyframe = scene_map.map.AddKeyFrame(lost.frame, PoseOfFrame(10));
  tracker.Anchor(lost, keyframe);
  const auto seen = keyframe.frame.features;
  tracker.sensor.CompensateAll(&scene_map.map);
  EXPECT_EQ(keyframe.frame.features, seen);
}

TEST_F(TrackerTiming, ACameraAtRestGivesNoEstimate) {
  TrackerInSystem tracker(model, {}, {.colour_readout = 0.02});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 60; ++i) Track(tracker, Look(scene, IdealSensor(), PoseOfFrame(0)), i);
  EXPECT_NEAR(tracker.sensor.timing().colour_readout, 0.02, 1e-6);
  EXPECT_GT(tracker.sensor.timing_estimate().sigma.colour_readout, 0.014);
}

}  // namespace
}  // namespace highwall::tracker_timing_test
