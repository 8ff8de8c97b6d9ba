#include "tracking/frame_refiner.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tracker_fixture.h"
#include "tracking/landmark_observations.h"

namespace highwall::frame_refiner_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::PoseOfFrame;
using testing::PositionError;
using testing::SyntheticView;
using testing::TrackerTest;

constexpr int kFrames = 40;
constexpr double kReadout = 0.025;  // [s]
// Lines have float pixels, which move a pose by some micrometres.
constexpr double kExact = 2e-5;

// Frames whose poses are 5 mm off, matched to a few of the landmarks that they see.
class FrameRefinerTest : public TrackerTest {
 protected:
  FrameRefinerTest() : keyframe_(scene_map.map.keyframe_ids().front()) {}

  Pose Truth(int i) const { return PoseOfFrame(i); }

  TrackedFrame MakeTracked(const SyntheticView& view, int i) const {
    const Pose off = Pose::FromTangent({0.005, 0, 0}, {0, 0, 0});
    TrackedFrame tracked = Unmatched(MakeFrame(view, i), Truth(i) * off);
    tracked.state = TrackingState::kTracking;
    tracked.by_image = true;
    const KeyFrame& keyframe = *scene_map.map.keyframe(keyframe_);
    // The keyframe sees the points of the scene in their order, as the view does.
    const SyntheticView seen = Look(scene, IdealSensor(), keyframe.T_WC);
    for (std::size_t k = 0; k < view.points.size() && tracked.num_points < 60; ++k) {
      const auto same = std::ranges::find(seen.points, view.points[k]);
      if (same == seen.points.end()) continue;
      tracked.points[k] = keyframe.points[static_cast<std::size_t>(same - seen.points.begin())];
      if (tracked.points[k] != kNoId) ++tracked.num_points;
    }
    return tracked;
  }

  void Add(FrameRefiner& refiner, const TrackedFrame& tracked, KeyFrameId newest,
           const RowMotion& moved_by = {}) {
    const PosedFrame posed{tracked.frame.stamp,
                           AnchoredPose::At(scene_map.map, keyframe_, tracked.T_WC)};
    frames.push_back(posed);
    refiner.Add(tracked, posed, moved_by, {}, newest);
  }

  double Error(int i) const {
    return PositionError(frames[static_cast<std::size_t>(i)].pose.T_WC(scene_map.map), Truth(i));
  }
  SyntheticView View(int i) const { return Look(scene, IdealSensor(), Truth(i)); }

  // Returns frame i as a rolling shutter, which reads out row after row, sees it.
  SyntheticView SeenByRows(int i) const {
    SyntheticView view = View(i);
    view.features =
        CompensatedToMiddleRow(*view.features, IdealSensor().camera, -kReadout, Motion(i));
    return view;
  }
  Twist Motion(int i) const {
    const double dt = ToSeconds(MakeFrame(View(i), 1).stamp - MakeFrame(View(i), -1).stamp);
    return Twist::Between(Truth(i - 1).Inverse() * Truth(i + 1), dt);
  }

  FrameRefiner Make(const FrameRefinementOptions& options, bool background = true,
                    const FrameRefinerParameters& parameters = {}) const {
    return FrameRefiner(model, IdealSensor().camera, options, TrackerOptions(), background,
                        parameters);
  }

  const KeyFrameId keyframe_;
  std::vector<PosedFrame> frames;
};

TEST_F(FrameRefinerTest, FindsPosesInTheMapAsItIsOnceEnoughKeyframesWereMade) {
  for (const bool background : {false, true}) {
    SCOPED_TRACE(background);
    frames.clear();
    FrameRefiner refiner = Make({}, background, {.keyframes = 3});
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_FALSE(refiner.HasResult());
      // The last frame comes three keyframes later.
      Add(refiner, MakeTracked(View(i), i), KeyFrameId(i < kFrames - 1 ? 1 : 4));
      refiner.Begin(scene_map.map, {});
    }
    refiner.Finish(scene_map.map, &frames);
    EXPECT_EQ(refiner.refined(), kFrames - 1);
    for (int i = 0; i < kFrames - 1; ++i) EXPECT_LT(Error(i), kExact) << i;
    EXPECT_NEAR(Error(kFrames - 1), 0.005, 1e-6);  // too recent
    refiner.FinishAll(scene_map.map, {}, &frames);
    EXPECT_LT(Error(kFrames - 1), kExact);
    EXPECT_FALSE(refiner.HasResult());
  }
}

TEST_F(FrameRefinerTest, FramesGetTheNoiseThatIsKnownByThen) {
  double information[2] = {};
  for (const bool known : {false, true}) {
    frames.clear();
    FrameRefiner refiner = Make({});
    Add(refiner, MakeTracked(View(0), 0), KeyFrameId(1));
    ImageKnowledge knowledge;
    if (known) knowledge.noise = testing::TwiceTheNoise();
    refiner.FinishAll(scene_map.map, knowledge, &frames);
    ASSERT_EQ(refiner.refined(), 1);
    EXPECT_LT(Error(0), kExact);
    information[known ? 1 : 0] = frames.front().information->trace();
  }
  EXPECT_NEAR(information[1] / information[0], 0.25, 0.01) << "up to a few more inliers";
}

TEST_F(FrameRefinerTest, HoldsNoMoreFramesThanItsLimit) {
  FrameRefiner refiner = Make({.waiting = 35}, false, {.keyframes = 3});
  for (int i = 0; i < 36; ++i) {
    Add(refiner, MakeTracked(View(i), i), KeyFrameId(1));
    refiner.Begin(scene_map.map, {});
    EXPECT_EQ(refiner.HasResult(), i == 35) << i;
  }
  refiner.Finish(scene_map.map, &frames);
  EXPECT_LT(Error(0), kExact);
  EXPECT_NEAR(Error(35), 0.005, 1e-6);
}

TEST_F(FrameRefinerTest, DoesNotRefineFramesWhosePoseIsNotFromTheirImage) {
  FrameRefiner refiner = Make({});
  for (int i = 0; i < 3; ++i) {
    TrackedFrame tracked = MakeTracked(View(i), i);
    if (i == 0) tracked.by_image = false;                         // it became a keyframe
    if (i == 1) tracked.open.push_back(UnobservableDirection());  // landmarks leave it unobservable
    Add(refiner, tracked, KeyFrameId(1));
  }
  refiner.FinishAll(scene_map.map, {}, &frames);
  EXPECT_NEAR(Error(0), 0.005, 1e-6);
  EXPECT_NEAR(Error(1), 0.005, 1e-6);
  EXPECT_LT(Error(2), kExact);
  EXPECT_EQ(refiner.refined(), 1);
}

TEST_F(FrameRefinerTest, RefinesThePoseByTheImageOfAFrameThatIsFusedWithAnImu) {
  FrameRefiner refiner = Make({});
  const TrackedFrame tracked = MakeTracked(View(0), 0);
  Add(refiner, tracked, KeyFrameId(1));
  frames.front().by_image = frames.front().pose;
  refiner.FinishAll(scene_map.map, {}, &frames);
  EXPECT_NEAR(Error(0), 0.005, 1e-6);
  EXPECT_LT(PositionError(frames.front().by_image->T_WC(scene_map.map), Truth(0)), kExact);
}

TEST_F(FrameRefinerTest, RefinesThePoseThatIsPredictedFromALateImage) {
  const Pose moved = Pose::FromTangent({0.02, 0.01, 0}, {0, 0, 0.01});
  FrameRefiner refiner = Make({});
  const TrackedFrame tracked = MakeTracked(View(0), 0);
  Add(refiner, tracked, KeyFrameId(1));
  PosedFrame& frame = frames.front();
  frame.by_image = frame.pose;
  frame.delay = 33'000'000;
  frame.pose = AnchoredPose::At(scene_map.map, keyframe_, tracked.T_WC * moved);
  refiner.FinishAll(scene_map.map, {}, &frames);
  EXPECT_LT(PositionError(frame.by_image->T_WC(scene_map.map), Truth(0)), kExact);
  EXPECT_LT(PositionError(frame.pose.T_WC(scene_map.map), Truth(0) * moved), kExact);
}

TEST_F(FrameRefinerTest, DoesNothingWhereItIsOff) {
  FrameRefiner refiner = Make({.enabled = false});
  Add(refiner, MakeTracked(View(0), 0), KeyFrameId(1));
  refiner.FinishAll(scene_map.map, {}, &frames);
  EXPECT_NEAR(Error(0), 0.005, 1e-6);
}

TEST_F(FrameRefinerTest, AFrameWhoseLandmarksHaveGoneKeepsItsPose) {
  FrameRefiner refiner = Make({});
  TrackedFrame tracked = MakeTracked(View(0), 0);
  tracked.num_points = 10000;  // far more than the map has at this time
  Add(refiner, tracked, KeyFrameId(1));
  refiner.FinishAll(scene_map.map, {}, &frames);
  EXPECT_NEAR(Error(0), 0.005, 1e-6);
  EXPECT_EQ(refiner.refined(), 0);
}

TEST_F(FrameRefinerTest, MovesRowsByTheMotionFromTheFrameBeforeToTheOneAfter) {
  // Errors after each round; the first and the last frame lack a neighbour on one side.
  std::vector<double> errors;
  for (const int rounds : {1, 3}) {
    frames.clear();
    FrameRefiner refiner = Make({}, true, {.rounds = rounds});
    for (int i = 0; i < kFrames; ++i) {
      Add(refiner, MakeTracked(SeenByRows(i), i), KeyFrameId(1));
    }
    refiner.FinishAll(scene_map.map, {.timing = FrameTiming{.colour_readout = kReadout}}, &frames);
    double worst = 0.0;
    for (int i = 5; i < kFrames - 5; ++i) worst = std::max(worst, Error(i));
    errors.push_back(worst);
  }
  EXPECT_GT(errors[0], 1e-3);
  EXPECT_LT(errors[1], 0.15 * errors[0]);
}

TEST_F(FrameRefinerTest, CorrectsTheDepthOfFramesFromBeforeItsPatternWasFound) {
  ImageKnowledge knowledge;
  knowledge.pattern.nodes.setConstant(0.02);
  FrameRefiner refiner = Make({});
  SyntheticView view = View(0);
  auto features = std::make_shared<FrameFeatures>(*view.features);
  for (PointFeature& point : features->points) point.depth /= 1.0 + 0.02 * point.depth;
  features->lines.clear();
  features->line_descriptors.release();
  view.features = features;
  Add(refiner, MakeTracked(view, 0), KeyFrameId(1));
  refiner.FinishAll(scene_map.map, knowledge, &frames);
  EXPECT_LT(Error(0), kExact);
}

TEST_F(FrameRefinerTest, ADroppedFrameIsPassedOver) {
  FrameRefiner refiner = Make({});
  for (int i = 0; i < 2; ++i) Add(refiner, MakeTracked(View(i), i), KeyFrameId(1));
  std::vector<PosedFrame> left{frames[1]};
  refiner.FinishAll(scene_map.map, {}, &left);
  EXPECT_EQ(refiner.refined(), 1);
  EXPECT_LT(PositionError(left[0].pose.T_WC(scene_map.map), Truth(1)), kExact);
}

}  // namespace
}  // namespace highwall::frame_refiner_test
