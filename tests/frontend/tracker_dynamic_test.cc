// Tracker with dynamic objects in the image.
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "box_world.h"
#include "features/depth_grid.h"
#include "tracker_fixture.h"

namespace highwall::tracker_dynamic_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::PoseOfFrame;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;
using testing::TrackerInSystem;
using testing::TrackerTest;

// A box with marks on it slides in front of the scene, 3 cm a frame.
class TrackerWithABox : public TrackerTest {
 protected:
  TrackerWithABox() : TrackerTest(150, 10) {
    std::mt19937 rng(3);
    for (int i = 0; i < kMarks; ++i) {
      const Eigen::Vector3d p_W(testing::Uniform(rng, -0.6, -0.4), testing::Uniform(rng, -0.3, 0.3),
                                kFront);
      marks.points.push_back({p_W, testing::RandomDescriptor(rng), 4.0});
    }
  }

  // Returns frame i of the box and the scene behind it; the marks come last.
  SyntheticView LookAt(int i, const Pose& T_WC) const {
    const Eigen::Vector3d shift(0.03 * i, 0.0, 0.0);
    Scene all;
    all.points = scene.points;
    for (testing::ScenePoint mark : marks.points) {
      mark.p_W += shift;
      all.points.push_back(mark);
    }
    return WithDepth(Look(all, IdealSensor(), T_WC), T_WC, shift);
  }
  // Adds the depth of the box, moved by `shift`, and of a wall and a floor behind it.
  SyntheticView WithDepth(SyntheticView view, const Pose& T_WC,
                          const Eigen::Vector3d& shift) const {
    auto features = std::make_shared<FrameFeatures>(*view.features);
    testing::BoxWorld world{.wall = 6.0, .floor = 3.0, .boxes = {}};
    world.boxes = {testing::Box{{-0.62, -0.4, kFront}, {-0.38, 0.4, kFront + 0.3}}.MovedBy(shift)};
    const PinholeCamera& camera = model.camera();
    features->depth_grid =
        DepthGrid(camera).Sample(testing::DepthOf(world, camera, T_WC), 0.3, 8.0);
    view.features = features;
    return view;
  }
  // Returns the number of remaining features that are nearer than the scene.
  static int MarksIn(const TrackedFrame& tracked) {
    int count = 0;
    for (const PointFeature& point : tracked.frame.features->points) {
      count += point.depth < kFront + 0.5 ? 1 : 0;
    }
    return count;
  }

  static constexpr int kMarks = 60;
  static constexpr double kFront = 1.3;  // [m]
  Scene marks;
};

TEST_F(TrackerWithABox, LeavesOutFeaturesOnDynamicObjects) {
  TrackerInSystem tracker(model, {}, {},
                          {.moving = {.settled = 0.3, .interval = 0.1, .history = 0.8}});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 20; ++i) {
    const SyntheticView view = LookAt(i, PoseOfFrame(i));
    const TrackedFrame tracked = Track(tracker, view, i);
    ExpectAt(tracked, PoseOfFrame(i), 1e-6);
    ASSERT_EQ(tracked.points.size(), tracked.frame.features->points.size());
    if (i < 14) continue;
    EXPECT_FALSE(tracked.moving.empty()) << i;
    EXPECT_LE(MarksIn(tracked), kMarks / 10) << i;
    // The rest of the scene stays, except where the box hides or has just uncovered it.
    EXPECT_GT(tracked.points.size(), 0.6 * static_cast<double>(view.points.size() - kMarks)) << i;
  }
}

// The box is static, and the landmarks, which are all behind it, give a pose that is 5.5 cm off:
// the box seems to have come nearer, by more than the 5 cm allowed for noise and pose. Surfaces
// show that it has not.
TEST_F(TrackerWithABox, FindsNoDynamicObjectsWhereSurfacesAgree) {
  for (const bool surfaces : {true, false}) {
    TrackerInSystem tracker(model, {.surfaces = {.enabled = surfaces}}, {},
                            {.moving = {.settled = 0.3, .interval = 0.1, .history = 0.8}});
    const auto look = [&](const Pose& eye, const Pose& T_WC) {
      return WithDepth(Look(scene, IdealSensor(), eye), T_WC, Eigen::Vector3d::Zero());
    };
    SceneMap still(scene);
    TrackedFrame first;
    first.T_WC = PoseOfFrame(0);
    const SyntheticView start = look(first.T_WC, first.T_WC);
    first.frame = MakeFrame(start, 0);
    tracker.Anchor(first, *still.map.keyframe(still.Add(start, first.T_WC)));
    for (int i = 1; i < 15; ++i) {
      const SyntheticView view = look(PoseOfFrame(i), PoseOfFrame(i));
      ASSERT_TRUE(tracker.Track(MakeFrame(view, i), still.map).moving.empty()) << i;
    }
    const Pose T_WC = PoseOfFrame(15), off = T_WC * Pose::FromTangent({0, 0, -0.055}, {0, 0, 0});
    Scene few;
    few.points.assign(scene.points.begin(), scene.points.begin() + 70);
    const SyntheticView last = WithDepth(Look(few, IdealSensor(), off), T_WC, {0, 0, 0});
    const TrackedFrame tracked = tracker.Track(MakeFrame(last, 15), still.map);
    ASSERT_EQ(tracked.state, TrackingState::kTracking);
    EXPECT_EQ(tracked.moving.empty(), surfaces);
  }
}

// The box is in the map, and no depth is old enough to show that it moves.
class TrackerWithABoxInTheMap : public TrackerWithABox {
 protected:
  TrackerWithABoxInTheMap() {
    all.points = scene.points;
    all.points.insert(all.points.end(), marks.points.begin(), marks.points.end());
  }
  // Tracks frames 1 to 8.
  std::vector<TrackedFrame> Run(const DynamicObjectParameters& moving) {
    TrackerInSystem tracker(model, {}, {}, {.moving = moving});
    SceneMap with_marks(all);
    TrackedFrame first;
    first.T_WC = PoseOfFrame(0);
    const SyntheticView start = LookAt(0, first.T_WC);
    first.frame = MakeFrame(start, 0);
    tracker.Anchor(first, *with_marks.map.keyframe(with_marks.Add(start, first.T_WC)));
    std::vector<TrackedFrame> frames;
    for (int i = 1; i < 9; ++i) {
      frames.push_back(tracker.Track(MakeFrame(LookAt(i, PoseOfFrame(i)), i), with_marks.map));
    }
    return frames;
  }

  Scene all;
};

TEST_F(TrackerWithABoxInTheMap, LeavesItOutAsItsLandmarksMove) {
  int i = 0;
  for (const TrackedFrame& tracked : Run({})) {
    ExpectAt(tracked, PoseOfFrame(++i), 1e-6);
    EXPECT_EQ(MarksIn(tracked), 0) << i;
    // The rest stays, except near the box in the image.
    const auto all_points = static_cast<double>(LookAt(i, PoseOfFrame(i)).points.size());
    EXPECT_GT(tracked.points.size(), 0.8 * (all_points - kMarks)) << i;
  }
}

TEST_F(TrackerWithABoxInTheMap, FollowsTheBoxWhereTooFewLandmarksContradict) {
  const auto frames = Run({.landmarks = {.min_points = kMarks + 1}});
  EXPECT_EQ(MarksIn(frames.back()), kMarks);
  EXPECT_GT(PositionError(frames.back().T_WC, PoseOfFrame(8)), 0.1);
}

TEST_F(TrackerWithABox, KeepsThemWhenTurnedOff) {
  TrackerInSystem tracker(model, {.moving = {.enabled = false}});
  Start(tracker, PoseOfFrame(0));
  for (int i = 1; i < 15; ++i) {
    const TrackedFrame tracked = Track(tracker, LookAt(i, PoseOfFrame(i)), i);
    EXPECT_TRUE(tracked.moving.empty());
    EXPECT_EQ(MarksIn(tracked), kMarks);
  }
}

}  // namespace
}  // namespace highwall::tracker_dynamic_test
