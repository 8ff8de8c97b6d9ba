#include <memory>

#include <gtest/gtest.h>

#include "painted_world.h"
#include "tracker_fixture.h"

namespace highwall {
namespace {

using testing::Look;
using testing::SceneMap;
using testing::SeeGrids;
using testing::SyntheticView;

// A camera whose second image is smeared: no corner and no line is left, but light and dark are.
class TrackerDirectTest : public testing::TrackerTest {
 protected:
  TrackerDirectTest() : TrackerTest(500, 40, false) {}

  // The first frame, with everything.
  void Start(Tracker& tracker) {
    SyntheticView view = Look(scene, testing::IdealSensor(), kStart);
    auto features = std::make_shared<FrameFeatures>(*view.features);
    const FrameFeatures grids = SeeGrids(testing::kBoxes, kStart);
    features->depth_grid = grids.depth_grid;
    features->gray_grid = grids.gray_grid;
    view.features = features;
    const KeyFrameId id = scene_map.Add(view, kStart);
    TrackedFrame tracked;
    tracked.frame = testing::MakeFrame(view, 0);
    tracked.T_WC = kStart;
    tracker.Anchor(tracked, *scene_map.map.keyframe(id));
  }
  TrackedFrame TrackSmeared(Tracker& tracker, const testing::Light& light = {}) {
    SyntheticView view;
    view.features = std::make_shared<FrameFeatures>(SeeGrids(testing::kBoxes, kNext, light));
    return Track(tracker, view);
  }

  const Pose kStart = Pose::FromTangent({0.1, 0.0, -0.2}, {0.0, 0.02, 0.0});
  const Pose kNext = kStart * Pose::FromTangent({0.02, -0.05, 0.01}, {0.03, 0.01, -0.02});
};

TEST_F(TrackerDirectTest, ASmearedImageIsHeldByAllOfIt) {
  Tracker tracker(model, {});
  Start(tracker);
  const TrackedFrame tracked = TrackSmeared(tracker);
  // A tenth of a cell at the wall, 4 m away.
  ExpectAt(tracked, kNext, 0.005);
  EXPECT_EQ(tracked.num_points + tracked.num_lines, 0);
  EXPECT_GT(tracked.information.trace(), 0.0);
}

TEST_F(TrackerDirectTest, WithoutItTheFrameIsLost) {
  TrackerOptions options;
  options.direct.enabled = false;
  Tracker tracker(model, options);
  Start(tracker);
  EXPECT_EQ(TrackSmeared(tracker).state, TrackingState::kLost);
}

TEST_F(TrackerDirectTest, AnotherPlaceIsNotHeld) {
  Tracker tracker(model, {});
  Start(tracker);
  EXPECT_EQ(TrackSmeared(tracker, {.phase = 1.7}).state, TrackingState::kLost);
}

TEST_F(TrackerDirectTest, TheNextSharpFrameFindsTheLandmarksAgain) {
  Tracker tracker(model, {});
  Start(tracker);
  TrackSmeared(tracker);
  const Pose after = kNext * Pose::FromTangent({0.01, -0.02, 0.0}, {0.01, 0.0, 0.0});
  SyntheticView view = Look(scene, testing::IdealSensor(), after);
  const TrackedFrame tracked = Track(tracker, view, 2);
  ExpectAt(tracked, after, 1e-4);
  EXPECT_GT(tracked.num_points, 100);
}

}  // namespace
}  // namespace highwall
