// Rejections by Tracker although enough landmarks agree with a pose: a place that only looks
// similar, and depth that contradicts the map.
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "box_world.h"
#include "features/depth_grid.h"
#include "tracker_fixture.h"

namespace highwall::tracker_recognition_test {
namespace {

using testing::BoxWorld;
using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PoseOfFrame;
using testing::Scene;
using testing::SyntheticView;
using testing::TrackerInSystem;
using testing::TrackerTest;

class RecognitionTest : public TrackerTest {
 protected:
  RecognitionTest() : TrackerTest(500, 40, false) {}

  // Returns the scene in which a share of the landmarks is replaced by others.
  Scene Changed(double share) const {
    Scene changed = scene;
    std::mt19937 rng(4);
    const auto gives_way = [&] { return testing::Uniform(rng, 0.0, 1.0) < share; };
    for (std::size_t i = 0; i < changed.points.size(); ++i) {
      if (gives_way()) changed.points[i] = foreign.points[i];
    }
    for (std::size_t i = 0; i < changed.lines.size(); ++i) {
      if (gives_way()) changed.lines[i] = foreign.lines[i];
    }
    return changed;
  }
  // world: source of the depth, independent of the landmarks.
  SyntheticView See(const Scene& seen, const BoxWorld& world, int frame) const {
    SyntheticView view = Look(seen, IdealSensor(), PoseOfFrame(frame));
    auto features = std::make_shared<FrameFeatures>(*view.features);
    features->depth_grid =
        grid.Sample(testing::DepthOf(world, IdealSensor().camera, PoseOfFrame(frame)), 0.3, 8.0);
    view.features = features;
    return view;
  }
  // Tracks some frames that find all expected landmarks; the first is the keyframe.
  void Begin(TrackerInSystem& tracker) {
    const SyntheticView view = See(scene, room, 0);
    TrackedFrame tracked;
    tracked.frame = MakeFrame(view, 0);
    tracked.T_WC = PoseOfFrame(0);
    tracker.Anchor(tracked, *scene_map.map.keyframe(scene_map.Add(view, PoseOfFrame(0))));
    for (int i = 1; i < 5; ++i) {
      ASSERT_EQ(Track(tracker, See(scene, room, i), i).state, TrackingState::kTracking) << i;
    }
  }
  // Tracks `view` next; if `lost`, after a frame without any features.
  TrackedFrame Next(const SyntheticView& view, bool lost,
                    const TrackerParameters& parameters = {}) {
    TrackerInSystem tracker(model, {}, {}, parameters);
    Begin(tracker);
    if (lost) {
      const SyntheticView nothing = Look(Scene(), IdealSensor(), PoseOfFrame(5));
      EXPECT_EQ(Track(tracker, nothing, 5).state, TrackingState::kLost);
    }
    return Track(tracker, view, lost ? 6 : 5);
  }

  // There is a box on one side, and one on the other: each room sees through the box of the other.
  const BoxWorld room{.boxes = {{{-1.6, -1.2, 2.0}, {-0.3, 1.0, 2.5}}}};
  const BoxWorld mirrored{.boxes = {{{0.3, -1.2, 2.0}, {1.6, 1.0, 2.5}}}};
  const BoxWorld empty{};
  const DepthGrid grid{IdealSensor().camera};
};

constexpr bool kLost = true, kFollowed = false;

TEST_F(RecognitionTest, RejectsASimilarPlaceOfWhichLittleIsFound) {
  const SyntheticView most = See(Changed(0.3), room, 6), little = See(Changed(0.65), room, 6);
  const TrackedFrame found = Next(most, kLost);
  ExpectAt(found, PoseOfFrame(6), 1e-4);
  EXPECT_TRUE(found.relocalized);
  EXPECT_EQ(Next(little, kLost).state, TrackingState::kLost);

  TrackerParameters credulous;
  credulous.recognized_found = 0.0;
  ExpectAt(Next(little, kLost, credulous), PoseOfFrame(6), 1e-4);
}

// At a low rate, 0.2 m on the other side of the loop: views far apart have little in common.
TEST_F(RecognitionTest, LittleIsEnoughAtTheReferenceWhereACameraCanHaveMoved) {
  const auto after = [&](int frames, const BoxWorld& world) {
    TrackerInSystem tracker(model, {}, {}, {});
    Begin(tracker);
    return Track(tracker, See(Changed(0.65), world, 30), 4 + frames);
  };
  ExpectAt(after(16, room), PoseOfFrame(30), 1e-4);
  EXPECT_EQ(after(16, mirrored).state, TrackingState::kLost) << "depth of another place";
}

TEST_F(RecognitionTest, APlaceWhoseDepthContradictsTheMapIsAnother) {
  ExpectAt(Next(See(scene, room, 6), kLost), PoseOfFrame(6), 1e-4);
  EXPECT_EQ(Next(See(scene, mirrored, 6), kLost).state, TrackingState::kLost);

  TrackerParameters credulous;
  credulous.recognized_contradiction = 1.0;
  ExpectAt(Next(See(scene, mirrored, 6), kLost, credulous), PoseOfFrame(6), 1e-4);
}

TEST_F(RecognitionTest, ObjectsThatHaveGoneDoNotContradictThePlace) {
  ExpectAt(Next(See(scene, empty, 6), kLost), PoseOfFrame(6), 1e-4);
}

TEST_F(RecognitionTest, WithoutDepthOnEitherSideLandmarksAloneDecide) {
  ExpectAt(Next(Look(scene, IdealSensor(), PoseOfFrame(6)), kLost), PoseOfFrame(6), 1e-4);
}

// Tracked frames, not lost ones: a frame may find little for a while, and much of it may be new.
TEST_F(RecognitionTest, AFrameThatFollowsIsRefusedOnlyWhereItFindsLittleAndDepthContradictsIt) {
  const Scene little = Changed(0.65);
  ExpectAt(Next(See(little, room, 5), kFollowed), PoseOfFrame(5), 1e-4);
  ExpectAt(Next(See(scene, mirrored, 5), kFollowed), PoseOfFrame(5), 1e-4);
  EXPECT_EQ(Next(See(little, mirrored, 5), kFollowed).state, TrackingState::kLost);
}

}  // namespace
}  // namespace highwall::tracker_recognition_test
