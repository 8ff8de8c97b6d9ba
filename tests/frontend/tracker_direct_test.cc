#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/map/anchored_pose.h>

#include "painted_world.h"
#include "tracker_fixture.h"

namespace highwall::tracker_direct_test {
namespace {

using testing::Look;
using testing::SceneMap;
using testing::SeeGrids;
using testing::SyntheticView;
using testing::TrackerInSystem;

// A camera whose second image is smeared: no corner and no line is left, only coarse grey levels.
class TrackerDirectTest : public testing::TrackerTest {
 protected:
  TrackerDirectTest() : TrackerTest(500, 40, false) {}

  // Tracks the first frame, with all features.
  void Start(TrackerInSystem& tracker) {
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
  TrackedFrame TrackSmeared(TrackerInSystem& tracker, const testing::Light& light = {},
                            const testing::BoxWorld& world = testing::kBoxes, int index = 1) {
    SyntheticView view;
    view.features = std::make_shared<FrameFeatures>(SeeGrids(world, kNext, light));
    return Track(tracker, view, index);
  }

  const Pose kStart = Pose::FromTangent({0.1, 0.0, -0.2}, {0.0, 0.02, 0.0});
  const Pose kNext = kStart * Pose::FromTangent({0.02, -0.05, 0.01}, {0.03, 0.01, -0.02});
};

TEST_F(TrackerDirectTest, ASmearedImageIsHeldByAllOfIt) {
  TrackerInSystem tracker(model, {});
  Start(tracker);
  const TrackedFrame tracked = TrackSmeared(tracker);
  // The tolerance is a tenth of a cell at the wall, 4 m away.
  ExpectAt(tracked, kNext, 0.005);
  EXPECT_EQ(tracked.num_points + tracked.num_lines, 0);
  EXPECT_GT(tracked.information.trace(), 0.0);
  ASSERT_TRUE(tracked.image_motion);
  const Pose T_WC = kStart * tracked.image_motion->T_reference_C;
  EXPECT_LT(testing::PositionError(T_WC, tracked.T_WC), 1e-12);
  // The information is that of the frame, along the axes of C.
  const Eigen::Matrix<double, 6, 6>& W = tracked.image_motion->sqrt_information;
  EXPECT_LT(
      (InformationInCamera(tracked.information, T_WC).cast<double>() - W.transpose() * W).norm(),
      1e-5 * tracked.information.norm());
}

TEST_F(TrackerDirectTest, WhereTheKeyframeDoesNotFitTheLastFrameHoldsAndStatesNoMotion) {
  TrackerInSystem tracker(model, {});
  Start(tracker);
  KeyFrame& keyframe = *scene_map.map.keyframe(scene_map.map.keyframe_ids().back());
  keyframe.T_WC = keyframe.T_WC * Pose::FromTangent({0, 0, 0}, {0.0, 3.0, 0.0});
  const TrackedFrame tracked = TrackSmeared(tracker);
  ExpectAt(tracked, kNext, 0.005);
  EXPECT_FALSE(tracked.image_motion);
}

TEST_F(TrackerDirectTest, WithoutItTheFrameIsLost) {
  TrackerOptions options;
  options.direct.enabled = false;
  TrackerInSystem tracker(model, options);
  Start(tracker);
  EXPECT_EQ(TrackSmeared(tracker).state, TrackingState::kLost);
}

TEST_F(TrackerDirectTest, AnotherPlaceIsNotHeld) {
  TrackerInSystem tracker(model, {});
  Start(tracker);
  EXPECT_EQ(TrackSmeared(tracker, {.phase = 1.7}).state, TrackingState::kLost);
}

TEST_F(TrackerDirectTest, RejectsAnotherDepthHoweverSimilarTheGreyLevels) {
  // The box stands on the other side: each view shows a surface in front of the other's.
  const testing::BoxWorld moved{.boxes = {testing::kBoxes.boxes[0].MovedBy({1.8, 0.0, 0.0})}};
  TrackerParameters parameters;
  parameters.min_correlation = 0.0;
  TrackerInSystem tracker(model, {}, {}, parameters);
  Start(tracker);
  EXPECT_EQ(TrackSmeared(tracker, {}, moved).state, TrackingState::kLost);
  parameters.recognized_contradiction = 1.0;
  TrackerInSystem unaware(model, {}, {}, parameters);
  Start(unaware);
  EXPECT_EQ(TrackSmeared(unaware, {}, moved).state, TrackingState::kTracking)
      << "nothing else refuses it";
}

TEST_F(TrackerDirectTest, HoldsForHalfASecondAtMost) {
  TrackerInSystem tracker(model, {});
  Start(tracker);
  for (int i = 1; i <= 15; ++i) {
    EXPECT_EQ(TrackSmeared(tracker, {}, testing::kBoxes, i).state, TrackingState::kTracking) << i;
  }
  EXPECT_EQ(TrackSmeared(tracker, {}, testing::kBoxes, 16).state, TrackingState::kLost);
}

TEST_F(TrackerDirectTest, TheFewLandmarksThatAreLeftTakePart) {
  TrackerOptions options;
  options.surfaces.enabled = false;
  TrackerInSystem tracker(model, options);
  Start(tracker);
  // The points are too few to determine a pose alone (25), but enough with a known pose (12).
  const SyntheticView sharp = Look(scene, testing::IdealSensor(), kNext);
  auto features = std::make_shared<FrameFeatures>(SeeGrids(testing::kBoxes, kNext));
  const auto few = static_cast<std::ptrdiff_t>(20);
  features->points.assign(sharp.features->points.begin(), sharp.features->points.begin() + few);
  features->point_descriptors = sharp.features->point_descriptors.rowRange(0, 20).clone();
  testing::IndexPoints(*features, testing::IdealSensor().camera);
  SyntheticView view;
  view.features = features;
  const TrackedFrame tracked = Track(tracker, view);
  ExpectAt(tracked, kNext, 0.005);
  EXPECT_GE(tracked.num_points, 12);
}

TEST_F(TrackerDirectTest, GreyLevelsHoldAFrameOfFewLandmarks) {
  // Points enough for a pose (25) with errors of 2 px, as on edges along which corners slide.
  const SyntheticView sharp = Look(scene, testing::IdealSensor(), kNext);
  auto features = std::make_shared<FrameFeatures>(SeeGrids(testing::kBoxes, kNext));
  features->points.assign(sharp.features->points.begin(), sharp.features->points.begin() + 60);
  features->point_descriptors = sharp.features->point_descriptors.rowRange(0, 60).clone();
  const std::vector<PointFeature> exact = features->points;
  std::mt19937 rng(3);
  std::normal_distribution<double> normal(0.0, 2.0);
  const auto error = [&](bool enabled, const SyntheticView& view) {
    TrackerOptions options;
    options.direct.enabled = enabled;
    TrackerInSystem tracker(model, options);
    Start(tracker);
    const TrackedFrame tracked = Track(tracker, view);
    EXPECT_EQ(tracked.state, TrackingState::kTracking);
    EXPECT_GE(tracked.num_points, 25);
    return testing::PositionError(tracked.T_WC, kNext);
  };
  // Single draws differ by a factor of three.
  double with = 0.0, without = 0.0;
  for (int draw = 0; draw < 8; ++draw) {
    for (std::size_t i = 0; i < exact.size(); ++i) {
      features->points[i].uv = exact[i].uv + Eigen::Vector2d(normal(rng), normal(rng));
      features->points[i].depth = 0.0;
    }
    testing::IndexPoints(*features, testing::IdealSensor().camera);
    SyntheticView view;
    view.features = std::make_shared<FrameFeatures>(*features);
    with += error(true, view);
    without += error(false, view);
  }
  EXPECT_LT(with, 0.7 * without);
}

TEST_F(TrackerDirectTest, TheNextSharpFrameFindsTheLandmarksAgain) {
  TrackerInSystem tracker(model, {});
  Start(tracker);
  TrackSmeared(tracker);
  const Pose after = kNext * Pose::FromTangent({0.01, -0.02, 0.0}, {0.01, 0.0, 0.0});
  SyntheticView view = Look(scene, testing::IdealSensor(), after);
  const TrackedFrame tracked = Track(tracker, view, 2);
  ExpectAt(tracked, after, 1e-4);
  EXPECT_GT(tracked.num_points, 100);
}

}  // namespace
}  // namespace highwall::tracker_direct_test
